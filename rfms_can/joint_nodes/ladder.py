"""The safety ladder: for each fault, how many cycles in a row it may last, and what happens then.

Each node climbs its own ladder; safety never depends on the master being alive. A fault that lasts
is counted cycle by cycle (``FieldNode.miss``); one that happens at once (``FieldNode.trip``) has
one step, at its first cycle.
"""

from enum import IntEnum
from typing import Final

from rfms_can.tables import complete
from rfms_can.wire.vocabulary import FaultCode


class Reaction(IntEnum):
    """What a node does about a fault; the higher, the harder."""

    NONE = 0
    HOLD = 1  # R1: the last set-point stays
    STOP = 2  # R2: controlled stop with gravity compensation, then hold
    DAMP = 3  # R3: torque-capped damping
    OFF = 4  # R4: torque off, brake


Steps = tuple[tuple[int, Reaction], ...]

LADDERS: Final[dict[FaultCode, Steps]] = complete(
    {
        # 12 ms and 20 ms at 250 Hz (the 20-packet and 20 ms rules of today's arms), 100 ms (moteus)
        FaultCode.SYNC_MISSING: (
            (1, Reaction.HOLD),
            (3, Reaction.STOP),
            (5, Reaction.DAMP),
            (25, Reaction.OFF),
        ),
        FaultCode.SETPOINT_MISSING: (
            (1, Reaction.HOLD),
            (3, Reaction.STOP),
            (5, Reaction.DAMP),
            (25, Reaction.OFF),
        ),
        FaultCode.MEASURE_MISSING: ((1, Reaction.HOLD), (3, Reaction.OFF)),
        FaultCode.ERROR_MISSING: ((1, Reaction.HOLD), (3, Reaction.STOP)),
        FaultCode.ROWS_MISSING: ((1, Reaction.HOLD), (3, Reaction.STOP)),
        FaultCode.SETPOINT_STEP: ((1, Reaction.STOP),),
        FaultCode.ENCODER_GLITCH: ((1, Reaction.HOLD), (3, Reaction.STOP)),
        FaultCode.SOFT_LIMIT: ((1, Reaction.STOP),),
        FaultCode.HARD_LIMIT: ((1, Reaction.OFF),),
        FaultCode.HOMING_FAILED: ((1, Reaction.OFF),),
        FaultCode.DBC_MISMATCH: ((1, Reaction.OFF),),
        FaultCode.EMERGENCY_STOP: ((1, Reaction.OFF),),
        # 20 ms at 250 Hz: a motor that drives away must not be left to the controlled stop
        FaultCode.RUNAWAY: ((5, Reaction.OFF),),
        FaultCode.DUPLICATE_NODE: ((1, Reaction.STOP),),
        # a joint whose sensors or amplifier are not believed cannot hold itself: the brake can
        FaultCode.SENSOR_MISMATCH: ((1, Reaction.OFF),),
        FaultCode.SENSOR_STUCK: ((1, Reaction.OFF),),
        FaultCode.ADC_SATURATED: ((1, Reaction.HOLD), (3, Reaction.DAMP)),
        FaultCode.AMPLIFIER_FAULT: ((1, Reaction.HOLD), (2, Reaction.OFF)),
        FaultCode.OVERSPEED: ((1, Reaction.HOLD), (2, Reaction.OFF)),
        # its torque has not the effect that it should have: no controlled stop would be one
        FaultCode.FOLLOWING_ERROR: ((1, Reaction.HOLD), (2, Reaction.OFF)),
        FaultCode.OVERLOAD: ((1, Reaction.DAMP),),
        FaultCode.STALL: ((1, Reaction.DAMP),),
        FaultCode.ROWS_IMPLAUSIBLE: ((1, Reaction.HOLD), (3, Reaction.STOP)),
        FaultCode.FOREIGN_MASTER: ((1, Reaction.STOP),),
        FaultCode.BAD_FRAMES: ((1, Reaction.STOP),),
        FaultCode.BUS_OFF: ((1, Reaction.DAMP),),
        FaultCode.QUEUE_OVERFLOW: ((1, Reaction.HOLD), (3, Reaction.STOP)),
    },
    [fault for fault in FaultCode if fault is not FaultCode.NONE],
)


COUNTS: Final = max(FaultCode) + 1
"""Length of a list indexed by fault code."""


def rung(fault: FaultCode, reaction: Reaction) -> int:
    """Cycles in a row with a fault at which its ladder reaches a reaction; 0 below the first."""
    return next((cycles for cycles, reached in LADDERS[fault] if reached is reaction), 0)


class Ladder:
    """Counts consecutive cycles with a fault, one count for each kind of fault.

    Attributes:
        misses: counts, by fault code (a list: every cycle clears several).
    """

    __slots__ = ("misses",)

    def __init__(self) -> None:
        self.misses = [0] * COUNTS

    def miss(self, fault: FaultCode) -> Reaction:
        """One more cycle with the fault; the reaction it has reached."""
        self.misses[fault] += 1
        count, reached = self.misses[fault], Reaction.NONE
        for bound, reaction in LADDERS[fault]:
            if count >= bound:
                reached = reaction
        return reached

    def clear(self, fault: FaultCode) -> None:
        """A cycle without the fault."""
        self.misses[fault] = 0

    def reset(self) -> None:
        """Back to the ground, after RESET or START."""
        self.misses = [0] * COUNTS
