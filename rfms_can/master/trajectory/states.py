"""The states of the trajectory generator: one literal table (Table 3.3, Appendix C)."""

from enum import Enum, auto
from typing import Final

from rfms_can.errors import RfmsError
from rfms_can.tables import complete
from rfms_can.wire.vocabulary import TrajectoryState


class Stage(Enum):
    """Where the generator is; the comments name the states of Appendix C."""

    OFF = auto()
    """Not enabled: no set-points."""
    IDLE = auto()
    """At rest at a goal, or following one that moves (STATE0)."""
    START = auto()
    """Beginning of a transition (STATE3, row 3)."""
    BLEND = auto()
    """In a transition (STATE4, row 4)."""
    CURVE = auto()
    """In a Cartesian transition: T6 itself blends."""
    REJOIN = auto()
    """The cycle after a Cartesian transition into joint mode: the joints are told its line."""
    REJOINED = auto()
    """The cycles after that: p stays 1 until a lost frame would have been noticed."""
    LINEAR = auto()
    """Constant rate along the segment (STATE1, row 1)."""
    PRE = auto()
    """Along the segment, and looking at where the next one will start (STATE2, row 2)."""
    STOP = auto()
    """Row 1 with h slowing down to rest: a controlled stop along the path (STATE5)."""
    BRAKE = auto()
    """To rest in joint angles, beside a path that cannot be followed."""


class Event(Enum):
    """What takes the generator from one tick's stage to the next's."""

    ENABLE = auto()
    """A pose to hold is given: where a stop has ended, or in a transition that a pause holds."""
    DISABLE = auto()
    """Set-points end: a fault, or the drives go off."""
    STAY = auto()
    """Nothing ends with this tick."""
    PREPARE = auto()
    """The hand-over is near and the segment to hand over to is settled."""
    DEPART = auto()
    """This tick is -t_acc of the next segment."""
    BEND = auto()
    """This tick is the first past -t_acc of a segment with a Cartesian transition."""
    REJOIN = auto()
    """A Cartesian transition into joint mode is over."""
    BLENDED = auto()
    """The transition is over."""
    ARRIVED = auto()
    """The transition to rest is over."""
    HALT = auto()
    """A stop was requested."""
    BRAKE = auto()
    """The next set-point of the path cannot be sent: the joints cannot follow."""


TRANSITIONS: Final[dict[Stage, dict[Event, Stage]]] = complete(
    {
        Stage.OFF: {
            Event.ENABLE: Stage.IDLE,
            Event.DISABLE: Stage.OFF,
        },
        Stage.IDLE: {
            Event.ENABLE: Stage.IDLE,
            Event.DISABLE: Stage.OFF,
            Event.BRAKE: Stage.BRAKE,
            Event.STAY: Stage.IDLE,
            Event.DEPART: Stage.START,
            Event.BEND: Stage.CURVE,
        },
        Stage.START: {
            Event.DISABLE: Stage.OFF,
            Event.BRAKE: Stage.BRAKE,
            Event.STAY: Stage.BLEND,
        },
        Stage.BLEND: {
            Event.DISABLE: Stage.OFF,
            Event.BRAKE: Stage.BRAKE,
            Event.STAY: Stage.BLEND,
            Event.BLENDED: Stage.LINEAR,
            Event.PREPARE: Stage.PRE,
            Event.BEND: Stage.CURVE,
            Event.ARRIVED: Stage.IDLE,
            Event.HALT: Stage.STOP,
            Event.ENABLE: Stage.IDLE,
        },
        Stage.CURVE: {
            Event.DISABLE: Stage.OFF,
            Event.BRAKE: Stage.BRAKE,
            Event.STAY: Stage.CURVE,
            Event.REJOIN: Stage.REJOIN,
            Event.BLENDED: Stage.LINEAR,
            Event.PREPARE: Stage.PRE,
            Event.BEND: Stage.CURVE,
            Event.ARRIVED: Stage.IDLE,
            Event.HALT: Stage.STOP,
            Event.ENABLE: Stage.IDLE,
        },
        Stage.REJOIN: {
            Event.DISABLE: Stage.OFF,
            Event.STAY: Stage.REJOINED,
        },
        Stage.REJOINED: {
            Event.DISABLE: Stage.OFF,
            Event.STAY: Stage.REJOINED,
            Event.BLENDED: Stage.LINEAR,
            Event.PREPARE: Stage.PRE,
            Event.BEND: Stage.CURVE,
            Event.HALT: Stage.STOP,
        },
        Stage.LINEAR: {
            Event.DISABLE: Stage.OFF,
            Event.BRAKE: Stage.BRAKE,
            Event.STAY: Stage.LINEAR,
            Event.PREPARE: Stage.PRE,
            Event.BEND: Stage.CURVE,
            Event.HALT: Stage.STOP,
        },
        Stage.PRE: {
            Event.DISABLE: Stage.OFF,
            Event.BRAKE: Stage.BRAKE,
            Event.STAY: Stage.PRE,
            Event.DEPART: Stage.START,
            Event.HALT: Stage.STOP,
        },
        Stage.STOP: {
            Event.DISABLE: Stage.OFF,
            Event.BRAKE: Stage.BRAKE,
            Event.STAY: Stage.STOP,
            Event.ENABLE: Stage.IDLE,
        },
        Stage.BRAKE: {
            Event.DISABLE: Stage.OFF,
            Event.STAY: Stage.BRAKE,
            Event.ENABLE: Stage.IDLE,
        },
    },
    Stage,
)

ON_THE_WIRE: Final = complete(
    {
        Stage.IDLE: TrajectoryState.IDLE,
        Stage.START: TrajectoryState.START,
        Stage.BLEND: TrajectoryState.BLEND,
        Stage.CURVE: TrajectoryState.LINEAR,
        Stage.REJOIN: TrajectoryState.START,
        Stage.REJOINED: TrajectoryState.BLEND,
        Stage.LINEAR: TrajectoryState.LINEAR,
        Stage.PRE: TrajectoryState.PRE,
        Stage.STOP: TrajectoryState.LINEAR,
        Stage.BRAKE: TrajectoryState.LINEAR,
    },
    [stage for stage in Stage if stage is not Stage.OFF],
)
"""What the joints are told: to them a stop is a segment whose r changes ever more slowly, and a
Cartesian transition a segment that is not straight. It is PRE where it looks at a joint-mode goal
that moves, and the segment it leads into begins, in joint mode, with a START at p = 1."""


def following(stage: Stage, event: Event) -> Stage:
    """The stage after ``event``.

    Raises:
        RfmsError: ``event`` cannot happen in ``stage``.
    """
    target = TRANSITIONS[stage].get(event)
    if target is None:
        possible = ", ".join(known.name for known in TRANSITIONS[stage])
        raise RfmsError(
            f"trajectory generator: {event.name} cannot happen in {stage.name}, only {possible}"
        )
    return target
