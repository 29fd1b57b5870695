"""Vectors of the torque law: single cycles of a fresh servo, and runs of many cycles."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from generated import table

from node_book.printed import as_float32, number
from node_book.pump import JOINT, PERIOD_S, parameters
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.servo import Servo, ServoTerms
from rfms_can.joint_nodes.stop_ramp import StopRamp
from rfms_can.node.encoder_reference import EncoderReference
from rfms_can.wire.records import Measure, Reference, Rows
from rfms_can.wire.vocabulary import Law, Parameter

Six = tuple[float, float, float, float, float, float]
ZERO: Final[Six] = (0.0,) * 6
OWN: Final[Six] = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
"""Row of C of a rigid joint 3."""
C_ROW: Final[Six] = (0.1, -0.25, 0.5, 0.0, 0.125, 0.0)
M_ROW: Final[Six] = (0.0, 0.25, 0.5, 0.0, 0.0, 0.0)
ERRORS: Final[Six] = (0.002, -0.003, 0.004, 0.0, 0.001, 0.0)
RATES: Final[Six] = (0.01, 0.02, -0.03, 0.0, 0.04, 0.0)
ACCELERATIONS: Final[Six] = (0.5, 1.0, -2.0, 0.0, 0.0, 0.0)


class Case(NamedTuple):
    """What a cycle gives to joint 3; everything that is not named is 0."""

    words: str
    errors: Six = ZERO
    rates: Six = ZERO
    accelerations: Six = ZERO
    law_row: Six = OWN
    inertia_row: Six = ZERO
    gravity: float = 0.0
    law: Law = Law.PID
    damping: float = 0.0
    selection: int = 0
    specification: int = 0
    desired: float = 0.0
    speed: float = 0.0
    bias: float = 0.0
    cycle: int = 0


def _float32(values: Sequence[float]) -> tuple[float, ...]:
    return tuple(as_float32(x) for x in values)


def rows_of(case: Case) -> RowSets:
    """The active rows of a case."""
    rows = RowSets(JOINT)
    told = (*_float32(case.law_row), *_float32(case.inertia_row), as_float32(case.gravity))
    more = (1, case.law, as_float32(case.damping), case.selection, case.specification)
    rows.activate(Rows._make((*told, *more, 0)))
    return rows


def torque(servo: Servo, case: Case) -> float:
    """Torque of a cycle without the bias, as a joint computes it."""
    rows = rows_of(case)
    bias = servo.deliverable_bias(as_float32(case.bias))
    if rows.selection:
        friction = servo.friction.complying(
            case.desired, case.speed, servo.state.intended_speed, case.cycle
        )
    else:
        friction = servo.friction.rigid(case.desired)
    servo.recording = True
    six_of_each = (_float32(case.errors), _float32(case.rates), _float32(case.accelerations))
    return servo.torque(*six_of_each, rows, rows.gravity, friction, bias)


CASES: Final = (
    Case("error, rigid PID", errors=(0.0, 0.0, 0.004, 0.0, 0.0, 0.0)),
    Case("rate, rigid PID", rates=(0.0, 0.0, -0.03, 0.0, 0.0, 0.0)),
    Case("gravity", gravity=0.83),
    Case("accelerations", accelerations=ACCELERATIONS, inertia_row=M_ROW),
    Case("commanded speed", desired=0.5),
    Case("commanded speed below FRICTION_SPEED", desired=-0.0001),
    Case("bias", bias=1.0),
    Case("six errors and rates, PID", errors=ERRORS, rates=RATES, law_row=C_ROW),
    Case("the same, weighted", errors=ERRORS, rates=RATES, law_row=C_ROW, law=Law.WEIGHTED),
    Case(
        "complying, PID",
        *(ERRORS, RATES, ZERO, C_ROW, M_ROW),
        damping=4.0, selection=4, specification=1, speed=0.05,
    ),
    Case(
        "complying, weighted",
        *(ERRORS, RATES, ZERO, C_ROW, M_ROW),
        law=Law.WEIGHTED, damping=4.0, selection=4, specification=1, speed=0.05,
    ),
    Case("beyond the limit", errors=(0.0, 0.0, 0.2, 0.0, 0.0, 0.0), gravity=1.0, bias=2.0),
    Case(
        "all of it", ERRORS, RATES, ACCELERATIONS, C_ROW, M_ROW, 0.83, desired=-0.5, bias=-0.25
    ),
)  # fmt: skip

TERMS: Final = tuple(ServoTerms._fields)


def six(values: Six) -> str:
    """Six numbers."""
    return ", ".join(number(x) for x in values)


def given() -> str:
    """The rows and errors that the cases share."""
    shared = (
        *(("C", C_ROW), ("M", M_ROW), ("own", OWN)),
        *(("errors", ERRORS), ("rates", RATES), ("accelerations", ACCELERATIONS)),
    )
    return "\n".join(["```", *(f"{name:<14}{six(values)}" for name, values in shared), "```"])


def inputs(case: Case) -> str:
    """What of a case is not 0."""
    shared = {C_ROW: "C", M_ROW: "M", OWN: "own", ERRORS: "all", RATES: "all"}
    shared[ACCELERATIONS] = "all"
    said = []
    value: Six | float
    for field, value in zip(case._fields[1:], case[1:], strict=True):  # type: ignore[assignment]
        if value in (ZERO, OWN, 0):
            continue
        if not isinstance(value, tuple):
            said.append(f"{field} {number(value)}")
        elif value in shared:
            said.append(f"{field} {shared[value]}")
        else:
            place = next(i for i, x in enumerate(value) if x)
            said.append(f"{field.removesuffix('s')} {place + 1} {number(value[place])}")
    return ", ".join(said)


def single() -> str:
    """One cycle after START each: every term alone, and together."""
    rows = []
    for case in CASES:
        servo = Servo(parameters(), JOINT)
        own = torque(servo, case)
        bias = servo.terms.bias
        terms = [f"{n} {x:.6f}" for n, x in zip(TERMS, servo.terms, strict=True) if abs(x) > 1e-12]
        codes = (str(servo.code(own)), str(servo.force_code(bias)))
        rows.append((case.words, inputs(case), ", ".join(terms), f"{own:.6f}", *codes))
    columns = ("case", "given", "terms, Nm", "torque without bias, Nm", "current_dac", "force_dac")
    return table(columns, rows)


# --- runs ---------------------------------------------------------------------------------------


def _own(error: float) -> Six:
    return (0.0, 0.0, error, 0.0, 0.0, 0.0)


def rest_run() -> list[Case]:
    """A rigid joint that rests beyond its goal: friction turns, then the integral grows."""
    moving = [Case("", _own(0.001), desired=0.1)] * 2
    resting = [Case("", _own(-0.001))] * 66
    inside = [Case("", _own(0.0002))] * 2
    return [*moving, *resting, *inside]


def complying_run() -> list[Case]:
    """The arm begins to comply, and is rigid again; joint 3 moves, then rests with a dither."""
    rigid = [Case("", _own(0.001), gravity=0.83, desired=0.1)] * 3
    more = {"gravity": 0.83, "damping": 4.0, "selection": 4, "specification": 1}
    comply = [
        Case("", ERRORS, RATES, ZERO, C_ROW, M_ROW, speed=0.05 if k < 10 else 0.0, cycle=k, **more)  # type: ignore[arg-type]
        for k in range(3, 48)
    ]
    again = [Case("", _own(0.001), gravity=0.83, specification=2)] * 4
    return [*rigid, *comply, *again]


def _run(cases: list[Case], changes: dict[Parameter, float], shown: set[int]) -> str:
    servo = Servo({**parameters(), **changes}, JOINT)
    rows = []
    for cycle, case in enumerate(cases):
        total = torque(servo, case)
        t = servo.terms
        numbers = (t.integral, t.friction + t.dither, t.dither, t.transfer, total)
        if cycle in shown:
            codes = str(servo.code(total))
            rows.append((str(cycle), *(f"{x + 0.0:.6f}" for x in numbers), codes))
    columns = ("cycle", "integral", "friction and dither", "dither", "transfer")
    return table((*columns, "torque, Nm", "current_dac"), rows)


def rest() -> str:
    """The run of a resting joint."""
    return _run(rest_run(), {}, {0, 1, 2, 3, 4, 61, 62, 63, 64, 65, 66, 67, 68, 69})


def complying() -> str:
    """The run of a complying joint, with a dither of 0.8."""
    dither = {Parameter.DITHER_FRACTION: as_float32(0.8)}
    shown = {0, 1, 2, 3, 4, 5, 9, 10, 11, 20, 26, 27, 28, 29, 30, 34, 35, 39, 40, 45, 47, 48, 51}
    return _run(complying_run(), dither, shown)


# --- homing, stop -------------------------------------------------------------------------------


def references() -> str:
    """The encoder's zero from one MEASURE and one REFERENCE."""
    rows = []
    for counts, coarse, index, valid in (
        (-606, 884, -577, 1),
        (-606, 884, 0, 0),
        (0, 3000, 120, 1),
        (500, 3000, 120, 1),
        (-606, 1000, -577, 1),
        (20, 3215, 20, 1),
    ):
        encoder = EncoderReference(parameters())
        found = encoder.find(Measure(counts, 0, 0, 0, 0, 0), Reference(coarse, index, valid, 0))
        word = {None: "searching", True: "referenced", False: "HOMING_FAILED"}[found]
        zero = "" if encoder.zero_counts is None else str(encoder.zero_counts)
        angle = f"{encoder.angle(counts):.9f}" if found else ""
        told = (str(counts), str(coarse), str(valid), str(index))
        said = f"{encoder.coarse_angle(coarse):.9f}", f"{encoder.residual:.6f}"
        rows.append((*told, *said, word, zero, angle))
    columns = ("counts", "coarse_adc", "index_valid", "index_counts", "coarse angle", "residual")
    return table((*columns, "result", "zero", "θ"), rows)


def stop() -> str:
    """A stop ramp."""
    ramp = StopRamp(0.5, 0.15, as_float32(10.0), as_float32(PERIOD_S))
    rows = [("at QUICKSTOP", f"{ramp.position:.9f}", f"{ramp.speed:.6f}", "")]
    for cycle in range(1, 6):
        ramp.step()
        numbers = (f"{ramp.position:.9f}", f"{ramp.speed:.6f}", f"{ramp.acceleration:.4f}")
        rows.append((str(cycle), *numbers))
    return table(("cycle", "position", "speed", "acceleration"), rows)


def hold() -> str:
    """A stop whose joint comes to rest elsewhere, and is moved once more."""
    ramp = StopRamp(0.5, 0.15, as_float32(10.0), as_float32(PERIOD_S))
    rows = []
    for cycle in range(1, 22):
        angle = 0.5 + 0.0001 * min(cycle, 6) + (0.0002 if cycle > 19 else 0.0)
        ramp.step()
        ramp.watch(angle)
        if cycle in (1, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21):
            numbers = (f"{angle:.4f}", f"{ramp.speed:.6f}", f"{ramp.position:.9f}")
            rows.append((str(cycle), *numbers))
    return table(("cycle", "θ", "speed", "position"), rows)


def codes() -> str:
    """Torques to DAC codes."""
    servo = Servo(parameters(), JOINT)
    rows = []
    for value in (0.0, 1.0, -1.0, 0.0022, 9.5, -9.5):
        rows.append((number(value), str(servo.code(value)), str(servo.force_code(value))))
    return table(("torque, Nm", "current_dac", "force_dac"), rows)
