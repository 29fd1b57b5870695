"""The faults a system has to survive, row by row, and how each is provoked: one literal table.

The documentation (``docs/faults.md``), the campaign (``rfms faults``) and the tests come from it.
"""

from enum import Enum
from typing import Final, NamedTuple

from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.tables import complete


class State(Enum):
    """What the system does when the fault is put in; the value is told in the documentation."""

    MOVING = "all joints move at 30 to 55 % of their speed limits"
    NEAR_END = "the same, joint 1 close to the upper end of its range"
    COMPLYING = "at rest there, the arm complies in all directions"
    START = "power-up, before anything moves"
    AT_WRIST = "at rest before a straight wrist, holding a goal that an observation moves"


class Where(Enum):
    """On what system a variant is tried; the value is told in the documentation."""

    SIM = "all nodes in one process, on the simulated bus"
    PROCESSES = "a process for each node, on a hub or vcan0"


class Expected(Enum):
    """What has to come of a fault; the value is told in the documentation."""

    NONE = "none"
    """Nothing at all."""
    R0 = "R0"
    """Discarded and counted, the motion goes on."""
    R1 = "R1"
    """Counted, the last set-point is held, the motion goes on."""
    R2 = "R2"
    """A controlled stop of all joints."""
    R3 = "R3"
    """Torque-capped damping of the joint at fault, a stop of the others."""
    R4 = "R4"
    """Torque off and brake at the joint at fault, a stop of the others."""
    REJECTED = "reject"
    """The request is refused, nothing changes."""
    REFUSED = "refuse"
    """The arm is not enabled."""


GOES_ON: Final = frozenset((Expected.NONE, Expected.R0, Expected.R1, Expected.REJECTED))
"""Of these the motion must go on."""

HARDNESS: Final[dict[Expected, Reaction]] = complete(
    {
        Expected.NONE: Reaction.NONE,
        Expected.R0: Reaction.NONE,
        Expected.R1: Reaction.HOLD,
        Expected.R2: Reaction.STOP,
        Expected.R3: Reaction.DAMP,
        Expected.R4: Reaction.OFF,
        Expected.REJECTED: Reaction.NONE,
        Expected.REFUSED: Reaction.NONE,
    },
    Expected,
)
"""The reaction that the node at fault must reach."""

JOINT: Final = "joint"
"""As a culprit: the joint at fault."""
FOREIGN: Final = "foreign"
"""As a culprit: a sender that is no node of this bus."""
BUS: Final = "bus"
"""As a culprit: the bus itself."""
GOAL: Final = "goal"
"""As a culprit: the goal of a move, which moves by itself."""


class Variant(NamedTuple):
    """One way in which the fault of a row happens.

    Attributes:
        name: of the variant.
        bound: cycles from the first effect until it has to be found.
        expected: what has to come of it.
        culprit: who must be named: ``JOINT``, ``"master"``, ``"plant"``, ``FOREIGN``, ``BUS``,
            ``GOAL``; "" where nothing stops.
        state: what the system does.
        injector: its name in the catalogue of its system; the variant's if empty.
        where: on what system it is tried.
    """

    name: str
    bound: float
    expected: Expected
    culprit: str = ""
    state: State = State.MOVING
    injector: str = ""
    where: Where = Where.SIM

    @property
    def fault(self) -> str:
        """Name of its injector."""
        return self.injector or self.name


class Row(NamedTuple):
    """One fault.

    Attributes:
        fault: in words.
        detected_by: what shows it.
        bound: cycles until it is found, as a person would say.
        reaction: the same of what happens then.
        variants: ways in which it happens.
    """

    fault: str
    detected_by: str
    bound: str
    reaction: str
    variants: tuple[Variant, ...]


_E = Expected
_NONE, _R0, _R1, _R2, _R3, _R4 = _E.NONE, _E.R0, _E.R1, _E.R2, _E.R3, _E.R4


def _of_processes(
    name: str, bound: float, expected: Expected, culprit: str = "", injector: str = ""
) -> Variant:
    """A variant of a system of processes."""
    return Variant(name, bound, expected, culprit, State.MOVING, injector, Where.PROCESSES)


def _each(
    template: str, words: str, bound: float, expected: Expected, culprits: str = ""
) -> tuple[Variant, ...]:
    """A variant for each message, and who is to blame for each."""
    named = culprits.split() or [""] * len(words.split())
    return tuple(
        Variant(template.format(word), bound, expected, culprit)
        for word, culprit in zip(words.split(), named, strict=True)
    )


ROWS: Final[dict[int, Row]] = complete(
    {
        1: Row(
            *("lost frame", "counter gap, deadline", "1", "R1"),
            _each("lose_{}", "sync setpoint measure error dac rows", 1, _R1),
        ),
        2: Row(
            *("burst loss", "consecutive misses", "3", "R2"),
            (
                *_each("burst_{}", "sync setpoint", 3, _R2, "master master"),
                *_each("burst_{}", "measure error dac", 3, _R2, "plant joint joint"),
                Variant("deaf_plant", 3, _R2, "plant"),
                Variant("deaf_joint", 3, _R2, JOINT),
            ),
        ),
        3: Row(
            *("duplicate", "counter unchanged", "1", "R0"),
            _each("copy_{}", "setpoint measure error dac", 1, _R0),
        ),
        4: Row(
            *("delayed", "cycle echo", "1", "R0, R1"),
            _each("delay_{}", "setpoint measure error dac", 1, _R1),
        ),
        5: Row(
            *("reordered", "counter jump", "1", "R0, R1"),
            _each("swap_{}", "setpoint measure error dac", 1, _R1),
        ),
        6: Row(
            *("corrupt payload", "CRC", "1; 3 in 10: 10", "R0; 3 in 10: R2"),
            (
                *_each("corrupt_{}", "sync setpoint measure error dac", 1, _R0),
                *_each("corrupt_{}_often", "setpoint measure", 10, _R2, "master plant"),
                *_each("corrupt_{}_often", "error dac", 10, _R2, "joint joint"),
            ),
        ),
        7: Row(
            *("wrong length or kind", "exact match", "1", "R0"),
            (
                Variant("shorten_setpoint", 1, _R0),
                *_each("lengthen_{}", "measure error dac", 1, _R0),
                Variant("classic_dac", 1, _R0),
            ),
        ),
        8: Row(
            *("stuck counter (hung sender)", "run of zero steps", "3", "R2"),
            (
                *_each("stick_{}", "sync setpoint measure", 3, _R2, "master master plant"),
                *_each("stick_{}", "error dac", 3, _R2, "joint joint"),
            ),
        ),
        9: Row(
            *("stuck value, live counter", "variance against activity", "25", "R2"),
            (
                *_each("freeze_{}", "encoder tachometer", 25, _R2, "joint joint"),
                *_each("freeze_{}", "error dac setpoint", 25, _R2, "joint joint master"),
            ),
        ),
        10: Row(
            *("master dies", "SYNC absent", "3/5/25", "R2/R3/R4"),
            (
                Variant("stop_master", 3, _R2, "master"),
                Variant("stop_master: damped", 5, _R3, "master", injector="stop_master"),
                Variant("stop_master: off", 25, _R4, "master", injector="stop_master"),
                _of_processes("kill_master", 3, _R2, "master"),
                _of_processes("kill_master: off", 25, _R4, "master", "kill_master"),
            ),
        ),
        11: Row(
            *("node dies", "ERROR and DAC absent", "3", "plant brakes that joint, others R2"),
            (Variant("stop_joint", 3, _R2, JOINT), _of_processes("kill_joint", 3, _R2, JOINT)),
        ),
        12: Row(
            *("node rejoins", "boot id", "1", "stays PREOP until RESET"),
            (
                Variant("restart_joint", 1, _R2, JOINT),
                Variant("rejoin_joint", 3, _R2, JOINT),
                _of_processes("restart_process", 3, _R2, JOINT),
            ),
        ),
        13: Row(
            *("plant dies", "MEASURE absent", "3", "R4"),
            (Variant("mute_plant", 3, _R4, "plant"), _of_processes("kill_plant", 3, _R4, "plant")),
        ),
        14: Row(
            *("answer missing (a hung node)", "barrier, counted as a cycle", "1", "the ladder"),
            (
                Variant("hang_joint", 3, _R2, JOINT),
                Variant("hang_master", 3, _R2, "master"),
                _of_processes("pause_joint", 3, _R2, JOINT),
                _of_processes("pause_master", 3, _R2, "master"),
            ),
        ),
        15: Row(
            *("bus-off", "error frame, error counter", "1", "R3 locally, no automatic restart"),
            (
                Variant("bus_off_joint", 1, _R3, JOINT),
                # seen only when all processes have ended: in the time that R4 of a lost SYNC has
                _of_processes("cut_bus", 25, _R4, BUS),
            ),
        ),
        16: Row(
            *("babbling idiot", "rate over twice an identifier's, load over 95 %", "3", "R2"),
            (
                Variant("flood", 3, _R2, FOREIGN),
                Variant("babble_error", 3, _R2, JOINT),
                Variant("babble_heartbeat", 3, _R2, JOINT),
            ),
        ),
        17: Row(
            *("queue full, receive overflow", "errno, controller error", "1; 3", "R1; R2"),
            (
                Variant("full_queue_once", 1, _R1),
                Variant("full_queue", 3, _R2, JOINT),
                Variant("overrun_joint", 3, _R2, JOINT, injector="deaf_joint"),
                _of_processes("no_room_to_send", 3, _R2, JOINT),
            ),
        ),
        18: Row(
            *("wall clock jumps", "monotonic clocks only", "-", "none"),
            (_of_processes("wall_clock", 0, _NONE),),
        ),
        19: Row(
            *("cycle overrun", "finish deadline", "1; 3", "R1; R2"),
            (
                Variant("late_master_once", 1, _R1),
                Variant("late_master", 3, _R2, "master"),
            ),
        ),
        20: Row(
            *("NaN, infinity", "both ends", "1", "R0; set-point: R2"),
            (
                Variant("nan_setpoint_once", 1, _R0),
                Variant("nan_setpoint", 3, _R2, "master"),
                *_each("nan_{}_once", "error rows", 1, _R0),
            ),
        ),
        21: Row(
            *("out of range", "minimum and maximum of the DBC", "1", "R0"),
            (Variant("far_error_once", 1, _R0), Variant("far_error", 3, _R2, JOINT)),
        ),
        22: Row(
            *("encoder glitch", "step over 1.5 times the speed limit", "1", "R1; 3: R2"),
            (Variant("glitch_encoder", 1, _R1), Variant("jump_encoder", 3, _R2, JOINT)),
        ),
        23: Row(
            # What physics forbids: a coarse position that is off by whole index intervals agrees
            # with its index. Gravity would have to tell then: it does not load joint 1, joints 3 to
            # 6 less than their friction holds (tests/test_faults_gravity.py), and a load in the
            # hand may hide what is left of joint 2, where the index has found it.
            "encoder offset",
            "homing against the coarse position: off by a quarter of an index interval or more; "
            "whole intervals are hidden, gravity tells less of them than friction holds",
            *("25", "R2, refuse to enable"),
            (
                Variant("drift_encoder", 25, _R2, JOINT),
                Variant("turn_potentiometer", 0, _E.REFUSED, JOINT, State.START),
            ),
        ),
        24: Row(
            *("reversed sign, runaway", "motion away from the set-point", "5", "R4"),
            (
                *_each("reverse_{}", "motor encoder tachometer", 5, _R4, "joint joint joint"),
                Variant("stick_amplifier", 5, _R4, JOINT),
                *(
                    Variant(f"{name}: start", 0, _E.REFUSED, JOINT, State.START, name)
                    for name in ("reverse_motor", "reverse_encoder", "reverse_tachometer")
                ),
            ),
        ),
        25: Row(
            *("ADC saturated", "codes of the rails", "3", "R3"),
            _each("rail_{}", "current velocity", 3, _R3, "joint joint"),
        ),
        26: Row(
            *("over-torque, over-current", "clamp; I2t, stall", "1; 5", "clamp; R3"),
            (
                Variant("seize_brake", 5, _R3, JOINT),
                Variant("kill_amplifier", 5, _R3, JOINT),
                Variant("boost_amplifier", 5, _R3, JOINT),
            ),
        ),
        27: Row(
            *("soft limit of a joint", "position and stopping distance", "1", "R2"),
            (
                Variant("run_on", 1, _R2, "master", State.NEAR_END),
                Variant("push_to_the_end", 1, _R2, JOINT, State.COMPLYING),
            ),
        ),
        28: Row(
            *("hard limit of a joint", "position", "1", "R4"),
            (
                Variant("drive_to_the_end", 1, _R4, JOINT, State.NEAR_END),
                Variant("push_through", 1, _R4, JOINT, State.COMPLYING),
            ),
        ),
        29: Row(
            *("singularity", "smallest singular value of the Jacobian", "1", "scale speed, R2"),
            (
                Variant("ask_singular_line", 0, _E.REJECTED, "", State.AT_WRIST),
                Variant("slow_singular_line", 1, _NONE, "", State.AT_WRIST),
                Variant("lead_singular", 1, _R2, GOAL, State.AT_WRIST),
            ),
        ),
        30: Row(
            *("T6 unreachable or no rotation", "inverse kinematics, R'R = I", "0", "reject"),
            _each("ask_{}", "unreachable no_rotation", 0, _E.REJECTED),
        ),
        31: Row(
            *("set-point step", "velocity and acceleration limits", "1", "R0, R2"),
            (
                Variant("step_setpoint_once", 1, _R2, "master"),
                Variant("step_setpoint", 1, _R2, "master"),
            ),
        ),
        32: Row(
            *("redefinition that an accepted move could not follow", "world model, preview"),
            *("0", "reject, nothing changes"),
            _each("redefine_{}", "position mode", 0, _E.REJECTED),
        ),
        33: Row(
            *("malformed command", "schema", "0", "error, motion unchanged"),
            (Variant("ask_malformed", 0, _E.REJECTED),),
        ),
        34: Row(
            *("oversize program or queue", "caps", "0", "reject"),
            (Variant("ask_too_many", 0, _E.REJECTED),),
        ),
        35: Row(
            *("two masters", "foreign SYNC", "1", "R2, second refused"),
            (
                Variant("second_master", 1, _R2, "master"),
                Variant("foreign_sync", 1, _R2, "master"),
                _of_processes("start_master", 1, _R2, "master"),
            ),
        ),
        36: Row(
            *("duplicate node id", "own identifier received", "1", "R2 until RESET; else PREOP"),
            (
                Variant("second_joint", 1, _R2, JOINT),
                Variant("foreign_dac", 1, _R2, JOINT),
                _of_processes("start_joint", 1, _R2, JOINT),
                Variant("second_joint: start", 0, _E.REFUSED, JOINT, State.START, "second_joint"),
            ),
        ),
        37: Row(
            *("DBC mismatch", "hash in HEARTBEAT and SYNC", "before enable", "refuse"),
            (
                Variant("other_hash_joint", 0, _E.REFUSED, JOINT, State.START),
                Variant("other_hash_sync", 1, _R4, "master"),
            ),
        ),
        38: Row(
            *("rows that cannot be, half a set", "plausibility, set id", "before swap; 3"),
            "keep old set; 3: R2",
            (
                *_each("{}_once", "scale_rows wrong_gravity", 1, _R0),
                *_each("{}", "scale_rows wrong_gravity", 3, _R2, "master master"),
                Variant("half_set", 1, _R0, injector="lose_rows"),
            ),
        ),
        39: Row(
            *("log disk full", "writer", "-", "drop log, flag, control unharmed"),
            (_of_processes("full_disk", 0, _R0),),
        ),
    },
    range(1, 40),
)
"""By number. Bounds and reactions are those of the field: the 20-packet and 20 ms rules of today's
arms, 100 ms of moteus, profile 5 of AUTOSAR's end-to-end protection."""


def variants() -> list[tuple[int, Variant]]:
    """All variants with the numbers of their rows, in the order of the table."""
    return [(number, variant) for number, row in ROWS.items() for variant in row.variants]


def variant_of(row: int, name: str) -> Variant | None:
    """The variant of a row; None if there is none of this name."""
    found = [variant for variant in ROWS[row].variants if variant.name == name]
    return found[0] if found else None
