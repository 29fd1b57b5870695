"""Faults, the ladder and its reactions (docs/node.md, Missing frames, Faults)."""

NOTHING, HOLD, STOP, DAMP, OFF = range(5)  # reactions, softest first

(
    SYNC_MISSING,
    SETPOINT_MISSING,
    MEASURE_MISSING,
    ERROR_MISSING,
    ROWS_MISSING,
    SETPOINT_STEP,
    ENCODER_GLITCH,
    SOFT_LIMIT,
    HARD_LIMIT,
    HOMING_FAILED,
    DBC_MISMATCH,
    EMERGENCY_STOP,
    RUNAWAY,
    DUPLICATE_NODE,
    SENSOR_MISMATCH,
    SENSOR_STUCK,
    ADC_SATURATED,
    AMPLIFIER_FAULT,
    OVERSPEED,
    FOLLOWING_ERROR,
    OVERLOAD,
    STALL,
    ROWS_IMPLAUSIBLE,
    FOREIGN_MASTER,
    BAD_FRAMES,
) = range(1, 26)

LADDER: dict[int, dict[int, int]] = {
    SYNC_MISSING: {1: HOLD, 3: STOP, 5: DAMP, 25: OFF},
    SETPOINT_MISSING: {1: HOLD, 3: STOP, 5: DAMP, 25: OFF},
    MEASURE_MISSING: {1: HOLD, 3: OFF},
    ERROR_MISSING: {1: HOLD, 3: STOP},
    ROWS_MISSING: {1: HOLD, 3: STOP},
    ENCODER_GLITCH: {1: HOLD, 3: STOP},
    ADC_SATURATED: {1: HOLD, 3: DAMP},
    AMPLIFIER_FAULT: {1: HOLD, 2: OFF},
    OVERSPEED: {1: HOLD, 2: OFF},
    FOLLOWING_ERROR: {1: HOLD, 2: OFF},
    ROWS_IMPLAUSIBLE: {1: HOLD, 3: STOP},
}
"""After how many cycles in a row which reaction."""

AT_ONCE: dict[int, int] = {
    SETPOINT_STEP: STOP,
    SOFT_LIMIT: STOP,
    HARD_LIMIT: OFF,
    HOMING_FAILED: OFF,
    DBC_MISMATCH: OFF,
    EMERGENCY_STOP: OFF,
    RUNAWAY: OFF,
    DUPLICATE_NODE: STOP,
    SENSOR_MISMATCH: OFF,
    SENSOR_STUCK: OFF,
    OVERLOAD: DAMP,
    STALL: DAMP,
    FOREIGN_MASTER: STOP,
    BAD_FRAMES: STOP,
}
"""Reactions to faults that happen at once."""


def rung(fault: int, cycles: int) -> tuple[int, int]:
    """The reaction to so many cycles in a row, and at how many it came."""
    reached = [(bound, reaction) for bound, reaction in LADDER[fault].items() if cycles >= bound]
    bound, reaction = reached[-1]
    return reaction, bound
