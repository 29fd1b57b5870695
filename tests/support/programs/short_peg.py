"""The end of a peg's insertion: the mouth, the chamfer, 10 mm deep, and out again.

Needs ``tools`` on the path: ``PYTHONPATH=tools rfms run tests/support/programs/short_peg.py``.
"""

from example_run import example

program = example(
    "peg_in_hole",
    APPROACH_TIME=1.3,
    ABOVE=0.002,
    ENTRY_SPEED=0.008,
    ENTERED=0.004,
    GUIDED=0.006,
    DEPTH=0.010,
).program
