"""The engine of campaigns: one function, many jobs, on processes here or on a Dask cluster.

::

    kept = RESULTS.open(file, conditions)          # a file of earlier results, or none
    results = carry_out(jobs, lambda left: run(one, left, backend), kept, what="programs", ...)

``run`` alone hands back results as they come or in the order of the jobs; ``carry_out`` besides
leaves out what the file has, adds what is made, and shows how long it takes.
"""

from rfms_can.engine.backends import backend_of
from rfms_can.engine.campaign import carry_out
from rfms_can.engine.jobs import Backend, Serial, run
from rfms_can.engine.kept import Kept, ResultFile
from rfms_can.engine.processes import Processes
from rfms_can.engine.progress import Progress

__all__ = [
    "Backend",
    "Kept",
    "Processes",
    "Progress",
    "ResultFile",
    "Serial",
    "backend_of",
    "carry_out",
    "run",
]
