"""What the master tells programs: the arm's status, and whether what they wait for holds."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from rfms_can.kinematics import direct
from rfms_can.master.node import MasterNode
from rfms_can.master.phases import Phase
from rfms_can.messages import (
    AnyCondition,
    AtRest,
    CycleReached,
    Enabled,
    JawAtRest,
    MoveOver,
    Status,
)

NO_SENSORS: Final[Mapping[str, str]] = MappingProxyType({})


def holds(master: MasterNode, condition: AnyCondition) -> bool:
    """Whether a condition holds at the end of the last closed cycle."""
    match condition:
        case MoveOver(sequence):
            return master.motion.is_over(sequence) and not (
                master.motion.at_rest and master.force_control.comply.fading
            )
        case AtRest():
            return arm_at_rest(master)
        case JawAtRest():
            return master.stillness.jaw
        case CycleReached(cycle):
            return master.statistics.cycles >= cycle
        case Enabled():
            return master.phase is Phase.RUN


def arm_at_rest(master: MasterNode) -> bool:
    """Whether no move is under way or waits, nothing is commanded to move, and nothing does.

    An arm that follows a goal slowly stands still by its encoders from one cycle to the next; so
    does one that begins to return from a compliant displacement.
    """
    motion, comply = master.motion, master.force_control.comply
    stands_still = master.stillness.arm and not comply.fading
    return stands_still and motion.at_rest and not motion.following.moves


def status_of(
    master: MasterNode,
    lease: str | None = None,
    refused: int = 0,
    issued: int = 0,
    sensors: Mapping[str, str] = NO_SENSORS,
) -> Status:
    """The arm's state at the end of the last closed cycle.

    Args:
        master: the master.
        lease: who holds it.
        refused: requests refused so far.
        issued: statuses made before.
        sensors: states of the sensors, by name.
    """
    motion, state = master.motion, master.arm_state
    generator, force = motion.generator, master.force_control
    q1, q2, q3, q4, q5, q6 = state.q
    e1, e2, e3, e4, e5, e6 = master.inputs.errors
    cycle, settings = master.statistics.cycles, master.settings
    period = settings.period_ns * 1e-9
    return Status(
        cycle=cycle,
        time=max(cycle - 1, 0) * period,
        period=period,
        clock=settings.clock.name.lower(),
        phase=master.phase.name,
        stage=generator.stage.name,
        joints=(q1, q2, q3, q4, q5, q6),
        t6=direct(master.arm, state.q),
        errors=(e1, e2, e3, e4, e5, e6),
        sequence=generator.sequence,
        completed=generator.completed,
        waiting=generator.waiting,
        at_rest=arm_at_rest(master),
        jaw_at_rest=master.stillness.jaw,
        jaw=state.jaw_opening(master.arm.gripper),
        feed=generator.feed,
        comply=motion.comply,
        complying=master.rows.in_force.compliance.selection.word,
        complied=force.complied,
        force=force.force,
        force_loop=settings.force_loop,
        guard=force.guards.tripped,
        lease=lease,
        refused=refused,
        fault=master.fault,
        emergency=master.emergency is not None,
        issued=issued,
        sensors=dict(sensors),
        culprit=master.culprit,
    )
