"""What is done about a move that breaks a limit: another time, or a refusal that names one."""

from rfms_can.errors import MoveError
from rfms_can.master.trajectory.planning.limits import Excess
from rfms_can.master.trajectory.planning.search import Outcome, Trial
from rfms_can.master.trajectory.planning.times import LONGEST_S


def mended(trial: Trial, excess: Excess, *, lengthen: bool) -> Outcome:
    """The outcome with a longer segment time, where the mode allows it.

    Where no segment time helps, what breaks is the transition from the segment before, which is
    promised already: its speed must change within too short an acceleration time.

    Raises:
        MoveError: ``lengthen`` is false, or no segment time helps; the message has the time that
            would do.
    """
    tau = trial.frame.period_s
    longest = round(LONGEST_S / tau)
    slowed = trial.slowed(excess, longest)
    if slowed is not None and lengthen:
        return slowed
    refused = f"move {trial.base.segment.move.sequence}: {excess.what}"
    segment_time = trial.base.segment_time
    if slowed is not None:
        raise MoveError(
            f"{refused}: give the segment at least {slowed.base.segment_time:.6g} s instead of "
            f"{segment_time:.6g} s"
        )
    before = trial.departed.segment
    eased = trial.eased(excess, longest, longest if before.rests else before.move.room)
    if eased is None:
        remedy = (
            "place the path elsewhere, or move in joint mode"
            if before.rests
            else f"wait until move {before.move.sequence} is complete"
        )
        raise MoveError(f"{refused}, and no segment time helps: {remedy}")
    along = (
        f", with a segment of {eased.base.segment_time:.6g} s"
        if eased.base.segment_time > segment_time
        else ""
    )
    raise MoveError(
        f"{refused}, and no segment time helps: accelerate in "
        f"{eased.base.acceleration_time:.6g} s instead of {trial.base.acceleration_time:.6g} s"
        f"{along}"
    )
