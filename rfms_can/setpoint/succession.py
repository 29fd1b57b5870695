"""Valid sequences of set-points for a joint (Table 3.3): one literal table."""

from typing import Final

from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.wire.vocabulary import Mode, TrajectoryState

_STATES: Final = tuple(TrajectoryState)
_IDLE: Final = TrajectoryState.IDLE
_LINEAR: Final = TrajectoryState.LINEAR
_PRE: Final = TrajectoryState.PRE
_START: Final = TrajectoryState.START
_BLEND: Final = TrajectoryState.BLEND

FOLLOWS: Final = {
    _IDLE: frozenset((_IDLE, _BLEND, _LINEAR)),
    _START: frozenset((_IDLE, _PRE, _LINEAR)),
    _BLEND: frozenset((_START, _BLEND)),
    _LINEAR: frozenset((_IDLE, _BLEND, _LINEAR, _PRE, _START)),
    _PRE: frozenset((_BLEND, _LINEAR, _PRE)),
}
"""The states a set-point of each state may follow.

IDLE after LINEAR ends a controlled stop, LINEAR after PRE is a stop that began there, and LINEAR
after START one of an arm that cannot follow its path; START after
LINEAR is a lost PRE. A BLEND whose START was lost cannot be computed and is refused. LINEAR after
IDLE begins a Cartesian transition: in Cartesian mode, and with p > 0. IDLE after LINEAR with r = 0
ends one, and IDLE after BLEND ends a transition to rest, or one that was held.
"""
_MAY_FOLLOW: Final = [[last in FOLLOWS[state] for last in _STATES] for state in _STATES]
"""``FOLLOWS`` by state and last state: an enumeration's own hash would cost a call each cycle."""


def may_follow(setpoint: CartesianSetpoint, last: TrajectoryState) -> bool:
    """Whether ``setpoint`` may follow a set-point of state ``last``."""
    state = setpoint.state
    if state is _LINEAR and last is _IDLE:
        return setpoint.mode is Mode.CARTESIAN and setpoint.p > 0.0
    return _MAY_FOLLOW[state][last]
