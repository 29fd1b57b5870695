"""Tables of frames, states and faults, as the code has them."""

from typing import Final, NamedTuple

from generated import table

from node_book.pump import JOINT, Pump
from rfms_can.joint_nodes.ladder import LADDERS, Reaction
from rfms_can.joint_nodes.states import COMMAND_EVENTS, successor
from rfms_can.tables import complete
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState

F = FaultCode


def commands() -> str:
    """The state after each command, by the state before."""
    columns = ("state", *(command.name for command in Command if command is not Command.ANNOUNCE))
    rows = []
    for state in NodeState:
        after = [successor(state, COMMAND_EVENTS[c]) for c in Command if c in COMMAND_EVENTS]
        rows.append((state.name, *("" if s is None else s.name for s in after)))
    ordered = [command.name for command in Command if command in COMMAND_EVENTS]
    assert list(columns[1:]) == ordered
    return table(columns, rows)


def frames() -> str:
    """What a joint hears and sends, by identifier."""
    node, rows = Pump().node, []
    for codec in sorted(node.wire.codecs.values(), key=lambda codec: codec.id):
        sends = f"JOINT_{JOINT}" in codec.senders and codec.name not in NOT_OURS
        if codec.id in node.accepts or (sends and codec.name != "ESTOP"):
            what = "hears" if codec.id in node.accepts else "sends"
            rows.append((f"0x{codec.id:03X}", codec.name, str(codec.length), what))
    return table(("id", "frame", "bytes", f"joint {JOINT}"), rows)


NOT_OURS: Final = (f"MEASURE_{JOINT}", f"REFERENCE_{JOINT}", f"POSITION_{JOINT}")
"""What another joint may send: with sensors of its own, or a position loop in its board."""


class Raised(NamedTuple):
    """When a joint counts a fault, and what its EMCY says.

    Attributes:
        when: in words.
        culprit, frame, value, bound: fields of EMCY; where ``value`` is empty it is how many cycles
            in a row the fault has lasted, and the bound is the rung.
    """

    when: str
    culprit: str
    frame: str
    value: str = "cycles in a row"
    bound: str = "the rung: 3, 5 or 25"


def _own(when: str, value: str, bound: str) -> Raised:
    """What a joint finds wrong with its own sample or drive."""
    return Raised(when, "own number", "MEASURE_n", value, bound)


_CYCLE: Final = "in a cycle that owed a DAC and had none, "
RAISED: Final = complete(
    {
        F.SYNC_MISSING: Raised(
            "the watchdog of SYNC ran off: after 1.5 W, then each PERIOD", "8", "SYNC"
        ),
        F.SETPOINT_MISSING: Raised(
            _CYCLE + "MEASURE came and the own ERROR did not go out: a set-point frame is missing, "
            "of another cycle or refused (no solution, wrong succession)",
            *("8", "SETPOINT_1"),
        ),
        F.MEASURE_MISSING: Raised(
            _CYCLE + "MEASURE did not come",
            *("SENSOR_SOURCE", "MEASURE_n", "cycles in a row", "the rung: 3"),
        ),
        F.ERROR_MISSING: Raised(
            _CYCLE + "the ERROR of another joint did not come",
            *("lowest of the silent joints", "its ERROR", "cycles in a row", "the rung: 3"),
        ),
        F.ROWS_MISSING: Raised(
            "SYNC names a set of rows that is neither active nor here",
            *("8", "ROWS_n", "cycles in a row", "the rung: 3"),
        ),
        F.SETPOINT_STEP: Raised(
            "the commanded angle, or its rate, steps beyond the bound, or an ERROR signal does "
            "not fit",
            *("8", "SETPOINT_1", "the step, rad; of the rate, rad/s"),
            "1.5 SPEED_LIMIT PERIOD (1 + cycles held), rad; 0.2 SPEED_LIMIT",
        ),
        F.ENCODER_GLITCH: Raised(
            "the measured angle steps by more than the bound",
            *("own number", "MEASURE_n", "the step from the angle before, rad"),
            "1.5 SPEED_LIMIT PERIOD (cycles since the last sample), rad",
        ),
        F.SOFT_LIMIT: Raised(
            "where the joint would come to rest at ACCELERATION_LIMIT is beyond the bound",
            "8 where the commanded motion would come to rest beyond the range; else own number",
            *("SETPOINT_1; 0", "that angle, rad"),
            "POSITION_MIN - 0.02 or POSITION_MAX + 0.02, rad",
        ),
        F.HARD_LIMIT: Raised(
            "the measured angle is beyond the bound",
            *("own number", "0", "that angle, rad"),
            "POSITION_MIN - 0.05 or POSITION_MAX + 0.05, rad",
        ),
        F.HOMING_FAILED: Raised(
            "homing has failed (see homing)",
            *("own number", "REFERENCE_n; MEASURE_n where the encoder stands"),
            "what homing has failed with",
            "its bound there",
        ),
        F.DBC_MISMATCH: Raised(
            "SYNC carries another dbc_hash; once, until START or RESET",
            *("8", "SYNC", "the hash that came", "the own hash"),
        ),
        F.EMERGENCY_STOP: Raised("ESTOP, in any state but INIT", "0", "0", "0", "0"),
        F.RUNAWAY: Raised(
            "a rigid joint moves away from its set-point (see trust)",
            *("own number", "MEASURE_n", "its error, rad", "the bound of the error, rad"),
        ),
        F.DUPLICATE_NODE: Raised(
            "a frame came under an identifier of its own, in any state but INIT",
            *("own number", "that identifier", "1", "0"),
        ),
        F.SENSOR_MISMATCH: _own(
            "tachometer and encoder tell two motions, for a while",
            "their difference in this cycle, rad/s",
            "TACHOMETER_LIMIT",
        ),
        F.SENSOR_STUCK: _own(
            "the tachometer shows one code while the encoder's way of a cycle varies",
            "by how much it varies, rad/s",
            "0.1 SPEED_LIMIT + 3 / (COUNTS_PER_UNIT PERIOD), rad/s",
        ),
        F.ADC_SATURATED: _own(
            "velocity_adc is at a rail, or current_adc where no DAC explains it", "the code", "2047"
        ),
        F.AMPLIFIER_FAULT: _own(
            "the current is beyond what the last five DACs explain",
            *("current_adc", "the border it passed, codes"),
        ),
        F.OVERSPEED: _own(
            "the measured speed is beyond the bound", "that speed, rad/s", "OVERSPEED_LIMIT"
        ),
        F.FOLLOWING_ERROR: _own(
            "a rigid joint does not follow its set-point, or gets faster on its stop ramp",
            "its rate (in a stop its speed), rad/s; else its error, rad",
            "RATE_ERROR_LIMIT SPEED_LIMIT (in a stop and the speed at its begin); "
            "else FOLLOWING_ERROR_LIMIT",
        ),
        F.OVERLOAD: _own(
            "the heat of its torque is beyond the bound, and it rises",
            "the heat, N2 m2 s",
            "OVERLOAD_TIME (TORQUE_LIMIT^2 - CONTINUOUS_TORQUE^2)",
        ),
        F.STALL: _own(
            "its torque has been cut to TORQUE_LIMIT for STALL_TIME, and it stands",
            *("how long, s", "STALL_TIME"),
        ),
        F.ROWS_IMPLAUSIBLE: Raised(
            "SYNC names rows that are here and cannot be: they do not act",
            *("8", "ROWS_n", "the number that cannot be", "what it must be within, or be"),
        ),
        F.FOREIGN_MASTER: Raised(
            "SYNC more than four cycles from the last one, or HEARTBEAT_8 with another boot id",
            *("8", "SYNC; HEARTBEAT_8", "its cycle; its boot id"),
            "the last cycle; the boot id before",
        ),
        F.BAD_FRAMES: Raised(
            "the third frame of an identifier within ten cycles that is bad, its counter apart",
            *("its sender; 0 of ESTOP", "that identifier", "3", "10"),
        ),
        F.BUS_OFF: Raised(
            "its CAN controller has been off the bus since the last SYNC",
            *("own number", "0", "how often", "0"),
        ),
        F.QUEUE_OVERFLOW: Raised(
            "its CAN controller has lost frames since the last SYNC",
            *("own number", "0", "how many", "0"),
        ),
    },
    LADDERS,
)
"""What the page says of each fault."""


def faults() -> str:
    """When each fault counts, and what its EMCY says."""
    rows = []
    for fault, said in RAISED.items():
        steps = ", ".join(f"{cycles} {reaction.name}" for cycles, reaction in LADDERS[fault])
        rows.append((f"{fault.name} ({int(fault)})", said.when, steps, *said[1:]))
    columns = ("fault", "counts when", "ladder", "culprit", "frame", "value", "bound")
    return table(columns, rows)


def reactions() -> str:
    """What each reaction is, with the state it leads to."""
    state = {
        Reaction.HOLD: ("as it was", "no", "goes on; a cycle that lacks a frame sends no DAC, and "
                        "the board keeps the last one (by fault: below)"),
        Reaction.STOP: ("QUICKSTOP; from PREOP, HOMING, READY: PREOP", "yes",
                        "the stop ramp, then hold; in PREOP no DAC"),
        Reaction.DAMP: ("FAULT", "yes", "damping, at most a fifth of TORQUE_LIMIT, with gravity"),
        Reaction.OFF: ("FAULT", "yes", "one DAC 0, then silence: the brake closes"),
    }  # fmt: skip
    known = complete(state, [r for r in Reaction if r])
    return table(
        ("reaction", "state", "EMCY", "what the joint does"),
        [(reaction.name, *known[reaction]) for reaction in known],
    )
