"""One trial again, in this process, with a record of the whole run and a plot around the fault."""

from pathlib import Path
from typing import Final

from rfms_can.faults.trial import Result, Trial, result_of, watch_trial
from rfms_can.faults.warm import WarmSystem
from rfms_can.faults.watch import Moment
from rfms_can.rig.candump import CandumpWriter
from rfms_can.rig.record import Record
from rfms_can.rig.runner import complete_record

PLOT: Final = "fault.png"


def replay(trial: Trial, directory: Path) -> tuple[Result, list[Path]]:
    """Make a trial again.

    Args:
        trial: which.
        directory: of the record and the plot; made if it does not exist.

    Returns:
        Its result, and the files that were written.

    Raises:
        RfmsError: the directory cannot be written, or matplotlib is missing.
    """
    from rfms_can.faults.picture import draw  # noqa: PLC0415  # matplotlib is loaded only here

    record = Record(directory)
    warm = WarmSystem(trial.arm, trial.the_variant.state)
    writer = CandumpWriter(record.log, "sim0")
    warm.rig.observe(writer.write)
    try:
        warm.begin()
        warm.run_to(trial.cycle)
        watch = watch_trial(trial, warm)
    finally:
        complete_record(warm.session, warm.settings, record, writer)
    result = result_of(trial, watch.facts())
    moments: list[Moment] = watch.moments
    plots = [draw(trial, result, warm.arm, moments, directory / PLOT)] if moments else []
    return result, [record.log, *plots]
