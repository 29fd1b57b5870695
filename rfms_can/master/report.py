"""What the supervisor tells programs: the arm's status, and whether what they wait for holds."""

from rfms_can.kinematics import direct
from rfms_can.master.supervisor import Supervisor
from rfms_can.messages import (
    AnyCondition,
    AtRest,
    CycleReached,
    JawAtRest,
    MoveOver,
    Status,
)


def holds(supervisor: Supervisor, condition: AnyCondition) -> bool:
    """Whether a condition holds at the end of the last closed cycle."""
    match condition:
        case MoveOver(sequence):
            return supervisor.motion.is_over(sequence) and not (
                supervisor.motion.at_rest and supervisor.force_control.comply.fading
            )
        case AtRest():
            return stands(supervisor)
        case JawAtRest():
            return supervisor.stillness.jaw
        case CycleReached(cycle):
            return supervisor.statistics.cycles >= cycle


def stands(supervisor: Supervisor) -> bool:
    """Whether no move is under way or waits, nothing is commanded to move, and nothing does.

    An arm that follows a goal slowly stands still by its encoders from one cycle to the next; so
    does one that begins to come back from where compliance has let it go to.
    """
    motion, comply = supervisor.motion, supervisor.force_control.comply
    stands_still = supervisor.stillness.arm and not comply.fading
    return stands_still and motion.at_rest and not motion.moves


def status_of(supervisor: Supervisor, lease: str | None = None, refused: int = 0) -> Status:
    """The arm's state at the end of the last closed cycle.

    Args:
        supervisor: the master.
        lease: who holds it.
        refused: requests refused so far.
    """
    motion, state = supervisor.motion, supervisor.arm_state
    generator, force = motion.generator, supervisor.force_control
    q1, q2, q3, q4, q5, q6 = state.q
    e1, e2, e3, e4, e5, e6 = supervisor.errors
    cycle, settings = supervisor.statistics.cycles, supervisor.settings
    period = settings.period_ns * 1e-9
    return Status(
        cycle=cycle,
        time=max(cycle - 1, 0) * period,
        period=period,
        clock=settings.clock.name.lower(),
        phase=supervisor.phase.name,
        stage=generator.stage.name,
        joints=(q1, q2, q3, q4, q5, q6),
        t6=direct(supervisor.arm, state.q),
        errors=(e1, e2, e3, e4, e5, e6),
        sequence=generator.sequence,
        completed=generator.completed,
        waiting=generator.waiting,
        at_rest=stands(supervisor),
        jaw_at_rest=supervisor.stillness.jaw,
        jaw=state.jaw_opening(supervisor.arm.gripper),
        feed=generator.feed,
        comply=motion.comply,
        complying=supervisor.broadcast.in_force.selection.word,
        complied=force.complied,
        force=force.force,
        force_loop=settings.force_loop,
        guard=force.guards.tripped,
        lease=lease,
        refused=refused,
        fault=supervisor.fault,
    )
