"""What a joint does in a cycle: where its state, its reaction and SYNC's state meet, one table.

A row says what drives the torque, what goes out on the bus, and what is missed at the next SYNC.
The node reads its action when a cycle begins and whenever its state or reaction changes.
"""

from enum import Enum, auto
from itertools import product
from typing import Final, NamedTuple

from rfms_can.errors import TableError
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.tables import complete
from rfms_can.wire.vocabulary import NodeState


class TorqueSource(Enum):
    """What drives the torque."""

    NOTHING = auto()  # no DAC goes out: the board brakes the joint
    HOMING = auto()  # towards the index, at every REFERENCE
    HOLD = auto()  # where homing ended, at every REFERENCE
    SERVO = auto()  # Eq. 5.11, once SETPOINT, MEASURE and the six errors are here
    STOP_RAMP = auto()  # R2: along the ramp to rest, at every MEASURE
    DAMPING = auto()  # R3: brake the motion, capped, at every MEASURE


class StateAction(NamedTuple):
    """What a joint does in a cycle.

    Attributes:
        torque: what drives it.
        tells_error: whether its ERROR goes out.
        owes_dac: whether a cycle that ended without its DAC frame counts: as MEASURE missing, else
            as SETPOINT, else as ERROR missing.
        expects_setpoint: whether any other cycle without SETPOINT_1 counts as SETPOINT missing.
        bridges_encoder: whether a jump of the encoder is a fault, bridged by prediction.
        watches_range: whether leaving the joint's range is a fault.
        any_sample: whether samples of another cycle are taken: the plant goes on when SYNC fails.
    """

    torque: TorqueSource
    tells_error: bool = False
    owes_dac: bool = False
    expects_setpoint: bool = False
    bridges_encoder: bool = False
    watches_range: bool = False
    any_sample: bool = False

    @property
    def sends(self) -> tuple[str, ...]:
        """Frames the cycle puts on the bus, beside HEARTBEAT and EMCY."""
        dac = () if self.torque is TorqueSource.NOTHING else ("DAC",)
        return ("ERROR", *dac) if self.tells_error else dac


S, R, T = NodeState, Reaction, TorqueSource

IDLE: Final = StateAction(T.NOTHING)
HOME: Final = StateAction(T.HOMING)
HOLD: Final = StateAction(T.HOLD)
SERVO: Final = StateAction(
    T.SERVO, tells_error=True, owes_dac=True, bridges_encoder=True, watches_range=True
)
STOP: Final = StateAction(
    T.STOP_RAMP, owes_dac=True, bridges_encoder=True, watches_range=True, any_sample=True
)
DAMP: Final = StateAction(T.DAMPING, watches_range=True, any_sample=True)
OFF: Final = StateAction(T.NOTHING, any_sample=True)

ANY_REACTION: Final = tuple(Reaction)
ANY_SYNC: Final = tuple(NodeState)

Row = tuple[NodeState, tuple[Reaction, ...], tuple[NodeState, ...], StateAction]

_BUT_HOMING: Final = tuple(s for s in NodeState if s is not S.HOMING)
_BUT_OPERATIONAL: Final = tuple(s for s in NodeState if s is not S.OPERATIONAL)
_BUT_THESE: Final = tuple(s for s in _BUT_HOMING if s is not S.OPERATIONAL)
_BUT_DAMP: Final = tuple(r for r in Reaction if r is not R.DAMP)

# fmt: off
ROWS: Final[tuple[Row, ...]] = (
    # node state    reaction      state in SYNC       action
    (S.INIT,        ANY_REACTION, ANY_SYNC,           IDLE),
    (S.PREOP,       ANY_REACTION, ANY_SYNC,           IDLE),
    (S.HOMING,      ANY_REACTION, (S.HOMING,),        HOME),
    (S.HOMING,      ANY_REACTION, (S.OPERATIONAL,),   IDLE._replace(expects_setpoint=True)),
    (S.HOMING,      ANY_REACTION, _BUT_THESE,         IDLE),
    (S.READY,       ANY_REACTION, (S.HOMING,),        HOLD),
    (S.READY,       ANY_REACTION, _BUT_HOMING,        IDLE),
    (S.OPERATIONAL, ANY_REACTION, ANY_SYNC,           SERVO),
    (S.QUICKSTOP,   ANY_REACTION, (S.OPERATIONAL,),   STOP._replace(expects_setpoint=True)),
    (S.QUICKSTOP,   ANY_REACTION, _BUT_OPERATIONAL,   STOP),
    (S.FAULT,       (R.DAMP,),    (S.OPERATIONAL,),   DAMP._replace(expects_setpoint=True)),
    (S.FAULT,       (R.DAMP,),    _BUT_OPERATIONAL,   DAMP),
    (S.FAULT,       _BUT_DAMP,    ANY_SYNC,           OFF),
)
# fmt: on


def by_case(rows: tuple[Row, ...]) -> tuple[tuple[tuple[StateAction, ...], ...], ...]:
    """The action by node state, reaction and state in SYNC, in that order of indices.

    Raises:
        TableError: names a case without a row, or with two: a bug, raised at import.
    """
    cases: dict[tuple[NodeState, Reaction, NodeState], StateAction] = {}
    for state, reactions, bus_states, action in rows:
        for reaction, bus_state in product(reactions, bus_states):
            if (state, reaction, bus_state) in cases:
                raise TableError(
                    f"two actions for {state.name}, {reaction.name}, SYNC {bus_state.name}"
                )
            cases[state, reaction, bus_state] = action
    complete(cases, product(NodeState, Reaction, NodeState))
    return tuple(
        tuple(tuple(cases[s, r, b] for b in NodeState) for r in Reaction) for s in NodeState
    )


STATE_ACTIONS: Final = by_case(ROWS)
"""``STATE_ACTIONS[state][reaction][bus_state]``."""
