"""Inputs of the traces that ask for the law, homing and stopping; the node that plays has outputs.

Measured angles are whole counts of the bench (1/8000 rad), speeds whole codes (0.002 rad/s). The
joint of a trace is moved as the law is to be asked, and no encoder goes so where a tachometer says
what it says: ``FREE`` takes the detectors away, as far as a node lets them be taken.
"""

import math
import random
from collections.abc import Iterator
from typing import Any, Final

Cycle = dict[str, Any]
Trace = dict[str, Any]

COUNTS: Final = 8000.0
RATE: Final = 0.002
PERIOD_S: Final = 0.004
FREE: Final = {
    "SPEED_LIMIT": 100.0,
    "OVERSPEED_LIMIT": 150.0,
    "TACHOMETER_LIMIT": 100.0,
    "FOLLOWING_ERROR_LIMIT": 0.5,
    "STALL_TIME": 5.0,
    "STUCK_TIME": 1.0,
    "OVERLOAD_TIME": 60.0,
}
"""Bounds of the detectors that no trace meets that is about something else."""
AS_THE_BENCH: Final = {
    "SPEED_LIMIT": 2.0,
    "OVERSPEED_LIMIT": 3.0,
    "TACHOMETER_LIMIT": 2.0,
    "FOLLOWING_ERROR_LIMIT": 0.2,
    "STALL_TIME": 0.5,
    "STUCK_TIME": 0.1,
    "OVERLOAD_TIME": 5.0,
}
"""Those of the bench, where a trace is about steps and detectors."""
NO_FRICTION: Final = {"COULOMB_POSITIVE": 0.0, "COULOMB_NEGATIVE": 0.0, "VISCOUS": 0.0}
NO_GAINS: Final = {"KP": 0.0, "KI": 0.0, "KD": 0.0}
BARE: Final = {**NO_FRICTION, **NO_GAINS}
MIRRORED: Final = {
    "TORQUE_PER_CODE": -0.006,
    "COUNTS_PER_UNIT": -8000.0,
    "RATE_PER_CODE": -0.002,
    "COARSE_PER_CODE": -0.0015,
    "COARSE_ZERO": 3.0,
    "TORQUE_PER_FORCE_CODE": -0.004,
}
RIGID: Final = {"law_row": [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]}
COMPLYING: Final = {
    "law_row": [0.7, 0.2, -0.1, 0.05, -0.3, 0.15],
    "inertia_row": [0.06, 0.02, -0.01, 0.004, 0.0, -0.003],
    "gravity": 0.9,
    "selection": 5,
    "damping": 20.0,
    "specification": 3,
}
WEIGHTED: Final = {
    "law": "WEIGHTED",
    "law_row": [0.06, 0.02, -0.01, 0.004, 0.0, -0.003],
    "inertia_row": [0.06, 0.02, -0.01, 0.004, 0.0, -0.003],
    "gravity": -0.7,
}
WEIGHTED_COMPLYING: Final = {
    **WEIGHTED,
    "law_row": [0.05, 0.015, -0.008, 0.003, 0.001, -0.002],
    "selection": 9,
    "damping": 15.0,
}


def traces() -> list[Trace]:
    """All of them."""
    return [
        *terms(),
        *integrals(),
        *frictions(),
        *at_random(),
    ]


def counts(angle: float) -> float:
    """An angle in whole counts."""
    return round(angle * COUNTS) / COUNTS


def codes(speed: float) -> float:
    """A speed in whole codes."""
    return round(round(speed / RATE) * RATE, 6)


def trace(name: str, cycles: list[Cycle], changes: Cycle | None = None, **more: Any) -> Trace:
    """A trace without detectors, but for ``changes``; ``more`` as where it begins."""
    return {"name": name, "changes": {**FREE, **(changes or {})}, **more, "cycles": cycles}


def loads(*gravities: float, step: float = 2.4, **rows: Any) -> list[Cycle]:
    """Sets of rows that come to each gravity, Nm, in steps that a joint takes for a load."""
    cycles: list[Cycle] = []
    at = 0.0
    for gravity in gravities:
        while abs(gravity - at) > step:
            at += math.copysign(step, gravity - at)
            cycles.append({"rows": {**rows, "gravity": round(at, 6)}})
        at = gravity
        cycles.append({"rows": {**rows, "gravity": at}})
    return cycles


def held(cycles: int, **inputs: Any) -> list[Cycle]:
    """The same inputs for some cycles."""
    return [dict(inputs), *({} for _ in range(cycles - 1))]


def offsets(*errors: float, cycles: int = 2, begin: float = 0.0) -> list[Cycle]:
    """The joint beside its set-point 0.1 by errors, rad, reached in steps an encoder may take, and
    with a halt after each: what moves away cycle after cycle runs away."""
    path: list[Cycle] = []
    at = begin
    for error in errors:
        while abs(error - at) > 0.01:
            at += math.copysign(0.01, error - at)
            path += [{"measured": counts(0.1 - at)}, {}]
        at = error
        path += held(cycles, measured=counts(0.1 - error))
    return path


def moved(motion: Iterator[tuple[float, float]], lag: float = 0.0) -> list[Cycle]:
    """A joint that follows its set-point, ``lag`` rad behind."""
    return [
        {"angle": round(a, 7), "measured": counts(a - lag), "speed": codes(v)} for a, v in motion
    ]


def run_up(
    speed: float, cycles: int, begin: float = 0.1, at: int = 16
) -> Iterator[tuple[float, float]]:
    """Angles and speeds from rest to a speed within ``at`` cycles, then on at it."""
    angle, before = begin, 0.0
    for k in range(1, cycles + 1):
        x = min(1.0, k / at)
        v = speed * x**3 * (10.0 + x * (6.0 * x - 15.0))
        angle += 0.5 * (v + before) * PERIOD_S
        before = v
        yield angle, v


def slowing(at: float, speed: float, cycles: int) -> list[Cycle]:
    """A joint that brakes as the bench's stop does, and stands."""
    found = []
    for _ in range(cycles):
        speed = math.copysign(max(0.0, abs(speed) - 8.0 * PERIOD_S), speed)
        at += speed * PERIOD_S
        found.append({"measured": counts(at), "speed": codes(speed)})
    return found


def terms() -> list[Trace]:
    """Each term of the law alone, either sign."""
    errors = (0.001, -0.001, 0.02, -0.03, 0.15, 0.21, -0.15, -0.21, 0.0)
    speeds = [c for v in (0.1, -0.1, 1.5, -1.5, 2.4, -2.4, 0.002, -0.002) for c in held(2, speed=v)]
    each = [{"others": [[0.01 * (i == k), 0.0, 0.0] for i in range(5)]} for k in range(5)]
    rates = [{"others": [[0.0, 0.3 * (i == k), 0.0] for i in range(5)]} for k in range(5)]
    accelerations = [
        {"others": [[0.0, 0.0, 4.0 * (1.0 + k) * (i == k)] for i in range(5)]} for k in range(5)
    ]
    gravity = loads(2.5, -2.5, 9.0, 10.0, -10.0)
    inertia = {"inertia_row": [0.3, 0.1, -0.05, 0.07, 0.02, -0.03]}
    row = {"law_row": [0.6, 0.5, -0.4, 0.3, -0.2, 0.1]}
    comply = {**row, "selection": 1, "specification": 1}
    weighing = [0.3, 0.2, -0.1, 0.15, -0.05, 0.1]
    weighted = {"law": "WEIGHTED", "law_row": weighing, "inertia_row": weighing}
    damped = {**comply, "damping": 30.0}
    weighted_damped = {
        **weighted,
        "inertia_row": [0.5, 0.1, 0.2, -0.1, 0.05, 0.15],
        "selection": 2,
        "damping": 30.0,
        "specification": 1,
    }
    only_p = {**NO_FRICTION, "KI": 0.0, "KD": 0.0}
    only_d = {**NO_FRICTION, "KI": 0.0, "KP": 0.0}
    bias = [c for b in (0.5, -0.5, 3.0, -3.0, 8.4, -8.4, 0.0, None, 1.0) for c in held(2, bias=b)]
    moving = moved(run_up(1.2, 20)) + moved(run_up(-1.2, 4, 0.15, 3))[:0]
    settle = held(20, others=[[0.0, 0.0, 0.0]] * 5)
    return [
        trace("proportional", offsets(*errors), only_p, begin=0.1),
        trace("derivative", speeds, only_d, begin=0.1),
        trace("gravity", gravity, BARE, begin=0.1),
        trace("inertia", [{"rows": inertia}, *accelerations, *moving], BARE, begin=0.1),
        trace(
            "row of errors, complying",
            [{"rows": comply}, *settle, *each, *offsets(0.01, -0.01)],
            only_p,
            begin=0.1,
        ),
        trace("row of rates, complying", [{"rows": comply}, *settle, *rates], only_d, begin=0.1),
        trace(
            "damping of what complies",
            [{"rows": damped}, *settle, *rates, *speeds[:8]],
            {**only_p, "KP": 40.0},
            begin=0.1,
        ),
        trace(
            "weighted, errors",
            [{"rows": weighted}, *each, *offsets(0.02, -0.02)],
            only_p,
            begin=0.1,
        ),
        trace("weighted, rates", [{"rows": weighted}, *rates, *speeds[:8]], only_p, begin=0.1),
        trace(
            "weighted, damping of what complies",
            [{"rows": weighted_damped}, *settle, *rates, *speeds[:8]],
            only_p,
            begin=0.1,
        ),
        trace(
            "weighted, no gain",
            [{"rows": weighted}, *offsets(0.02, -0.02)],
            NO_FRICTION | {"KP": 0.0},
            begin=0.1,
        ),
        trace(
            "no natural frequency",
            [{"rows": damped}, *rates],
            {"NATURAL_FREQUENCY": 0.0},
            begin=0.1,
        ),
        trace("bias", bias, BARE, begin=0.1),
        trace(
            "bias and servo at the limit",
            [*offsets(0.16), *bias, *offsets(-0.16, begin=0.16), *bias],
            only_p,
            begin=0.1,
        ),
        trace("mirrored board", [*offsets(0.03, -0.03), *speeds[:8], *bias], MIRRORED, begin=0.1),
    ]


def integrals() -> list[Trace]:
    """Dead band, limit, anti-windup, and what becomes of them when compliance begins and ends."""
    only_i = {**NO_FRICTION, "KP": 0.0, "KD": 0.0}
    edge = [c for e in (1, -1, 2, -2, 1) for c in held(4, measured=counts(0.1 - e / COUNTS))]
    wound = [
        *offsets(0.06, cycles=45),
        *offsets(-0.06, cycles=80, begin=0.06),
        *offsets(0.0, begin=-0.06),
    ]
    others = [
        [0.01, 0.2, 0.0],
        [-0.004, 0.0, 1.0],
        [0.0002, 0.0, 0.0],
        [0.0003, 0.0, 0.0],
        [0.02, 0.0, 0.0],
    ]
    comply: Cycle = {
        **{"law_row": [0.6, 0.5, -0.4, 0.3, -0.2, 0.1], "selection": 1, "specification": 1}
    }
    weighted = {**comply, "law": "WEIGHTED", "law_row": [0.06, 0.05, -0.04, 0.03, -0.02, 0.01]}
    change = [
        *offsets(0.02, cycles=10),
        *held(60, rows=comply, others=others),
        *offsets(-0.02, cycles=20, begin=0.02),
        *held(25, rows={**RIGID, "specification": 2}),
        *held(25, rows={**comply, "specification": 4}),
    ]
    saturated = {**NO_FRICTION, "KP": 500.0, "KI": 4000.0, "KD": 0.0}
    return [
        trace("dead band of the integral", edge, only_i, begin=0.1),
        trace("limit of the integral", wound, only_i, begin=0.1),
        trace(
            "anti-windup",
            [*offsets(0.012, 0.03, 0.012, -0.03, 0.01, cycles=6)],
            saturated,
            begin=0.1,
        ),
        trace("integral and compliance", change, only_i, begin=0.1),
        trace(
            "integral and compliance, weighted",
            [{**c, "rows": weighted} if c.get("rows") is comply else c for c in change],
            {**NO_FRICTION, "KP": 60.0, "KD": 0.0},
            begin=0.1,
        ),
        trace(
            "bound of a complying integral",
            held(
                150,
                rows={**comply, "law_row": [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]},
                others=[[0.03, 0.0, 0.0]] * 5,
            ),
            {**only_i, "KI": 900.0},
            begin=0.1,
        ),
        trace(
            "anti-windup, complying",
            [
                *loads(9.9, -9.9, **comply)[:5],
                *held(40, others=[[0.02, 0.0, 0.0], *[[-0.02, 0.0, 0.0]] * 4]),
                *loads(9.9, -9.9, **comply)[5:],
                *held(20),
            ],
            {**NO_FRICTION, "KD": 0.0, "KP": 20.0},
            begin=0.1,
        ),
    ]


def frictions() -> list[Trace]:
    """Coulomb and viscous compensation, at rest, moving, complying; dither."""
    bare = {**NO_GAINS}
    there = moved(run_up(0.8, 24))
    at = there[-1]["angle"]
    slow = moved(run_up(0.009, 10, at))
    back = moved(run_up(-0.8, 24, at))
    creeping = [c for v in (0.009, -0.009) for c in moved(run_up(v, 12, 0.1, 6))]
    comply = {**COMPLYING, "gravity": 0.0, "inertia_row": [0.0] * 6, "damping": 0.0}
    speeds = [
        c for v in (0.0, 0.002, 0.004, -0.002, -0.004, 0.4, -0.4, 0.0) for c in held(3, speed=v)
    ]
    rest = held(30, rows=comply)
    return [
        trace("friction of a motion there and back", [*there, *slow, *back], bare, begin=0.1),
        trace("friction at creeping speeds", creeping, bare, begin=0.1),
        trace(
            "friction that turns at rest",
            [
                *there,
                *held(6, speed=0.0),
                *[{"measured": counts(at + 0.01)}, *held(70)],
                {"measured": counts(at)},
                *held(20, measured=counts(at - 0.01)),
            ],
            {"KP": 0.0, "KD": 0.0, "KI": 40.0},
            begin=0.1,
        ),
        trace(
            "friction, complying",
            [*rest, *speeds, *offsets(0.0003, 0.002, -0.0003, -0.002)],
            bare,
            begin=0.1,
        ),
        trace(
            "friction, complying, moving",
            [*rest, *moved(run_up(0.5, 12)), *held(20, rows=RIGID)],
            bare,
            begin=0.1,
        ),
        trace(
            "friction, compliance begun in motion",
            [
                *there,
                {**{}, "rows": comply},
                *held(30),
                *held(40, rows={**RIGID, "specification": 9}),
            ],
            bare,
            begin=0.1,
        ),
        trace(
            "dither",
            [
                *rest,
                *held(20, speed=0.0),
                *offsets(0.002, -0.002, cycles=8),
                *held(8, speed=0.1),
                *held(8, speed=0.0),
            ],
            {**bare, "DITHER_FRACTION": 0.8},
            begin=0.1,
        ),
        trace(
            "dither of a short period",
            [*rest, *held(12)],
            {**bare, "DITHER_FRACTION": 1.0, "DITHER_PERIOD": 0.004},
            begin=0.1,
        ),
        trace("dither, rigid", held(15), {**bare, "DITHER_FRACTION": 0.8}, begin=0.1),
        trace(
            "friction without a rate scale",
            [*rest, *offsets(0.002, -0.002)],
            {**bare, "NATURAL_FREQUENCY": 0.0},
            begin=0.1,
        ),
    ]


def at_random() -> list[Trace]:
    """All inputs at once."""
    return [
        random_trace("at random, rigid", 1, [RIGID]),
        random_trace("at random, PID complying", 2, [COMPLYING]),
        random_trace("at random, weighted", 3, [WEIGHTED]),
        random_trace("at random, weighted, complying", 4, [WEIGHTED_COMPLYING]),
        random_trace(
            "at random, laws in turn",
            5,
            [RIGID, COMPLYING, WEIGHTED, {**WEIGHTED_COMPLYING, "damping": 0.0}],
            DITHER_FRACTION=0.5,
        ),
        random_trace("at random, mirrored", 6, [RIGID, COMPLYING], **MIRRORED),
        random_trace(
            "at random, little torque",
            7,
            [WEIGHTED, COMPLYING],
            TORQUE_LIMIT=3.0,
            INTEGRAL_LIMIT=1.0,
            CONTINUOUS_TORQUE=1.0,
        ),
        random_trace("at random, another period", 8, [RIGID, COMPLYING], PERIOD=0.005),
    ]


def random_trace(name: str, seed: int, rows: list[Cycle], **changes: float) -> Trace:
    """A smooth motion, a joint that is anywhere near it, others that do as they like."""
    draw = random.Random(seed)
    cycles: list[Cycle] = []
    offset = 0.0
    load = 0.12 * changes.get("TORQUE_LIMIT", 10.0)
    for k in range(70):
        x = 2.0 * math.pi * k / 70.0
        angle = round(0.1 + 0.05 * (1.0 - math.cos(x)) + 0.012 * math.sin(2.0 * x) ** 3, 7)
        offset = 0.8 * offset + draw.uniform(-0.002, 0.002)
        cycle: Cycle = {
            "angle": angle,
            "measured": counts(angle - offset),
            "speed": codes(draw.uniform(-1.0, 1.0) if draw.random() < 0.7 else 0.0),
        }
        if k % 4 == 0:
            cycle["others"] = [
                [
                    round(draw.uniform(-0.02, 0.02), 4),
                    round(draw.uniform(-0.4, 0.4), 3),
                    round(draw.uniform(-3, 3), 2),
                ]
                for _ in range(5)
            ]
        if k % 14 == 0:
            drawn = draw.choice(rows)
            cycle["rows"] = {
                **drawn,
                "gravity": round(draw.uniform(-load, load), 3),
                "specification": k // 28,
            }
        if k % 9 == 3:
            cycle["bias"] = draw.choice((None, 0.7, -1.3, 2.1))
        if k % 11 == 5:
            cycle["comply"] = draw.choice((None, 0.001, -0.002, 0.003))
        cycles.append(cycle)
    return trace(name, cycles, dict(changes), begin=0.1)
