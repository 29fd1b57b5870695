"""Inputs of the traces about what a joint remembers: windows, rests, a start after another.

The curves are no polynomials of low degree: fits to other samples, or of other degrees, differ.
"""

import math
from typing import Any, Final

from conform_law_traces import PERIOD_S, Cycle, Trace, trace

BEGIN: Final = 0.1
"""Where all of them begin, rad."""
T_ACC: Final = 0.08

REACHING: Final = (
    # t_acc before, t_acc after, cycles of the transition before, cycles between; in periods
    (60, 190, 40, 3),
    (400, 190, 40, 3),
    (400, 143, 40, 3),
    (400, 203, 40, 3),
    (80, 200, 40, 3),
    (80, 200, 40, 25),
    (43, 100, 40, 3),
    (60, 20, 7, 2),
    (47, 100, 40, 8),
    (400, 66, 40, 3),
    (600, 511, 140, 3),
    (600, 512, 140, 3),
    (511, 513, 140, 3),
    (512, 512, 140, 3),
    (40, 23, 20, 16),
    (40, 58, 20, 40),
    (40, 66, 20, 40),
)
"""Transitions one after the other: how far the second reaches back into the first."""


def traces() -> list[Trace]:
    """All of them."""
    return [
        *(reaching(*case) for case in REACHING),
        reaching(80, 200, 40, 25, lost=(50, 60)),
        *(resting(*case) for case in RESTS),
        *(leaving(p, lost) for p in (True, False) for lost in ((), (30, 31, 39))),
        trace("arrived at a goal that moves, and on", arrived(), begin=BEGIN),
        trace("a set-point lost at rest, and on", lost_at_rest(), begin=BEGIN),
        trace("a set-point lost right after START, and on", lost_after_start(), begin=BEGIN),
        *(again(name, cycles, 0) for name, cycles in AGAIN.items()),
        again(
            "a joint segment, out of a pause before another", AGAIN["a joint segment at once"], 6
        ),
    ]


def curve(k: int) -> float:
    """Angle of cycle k of a motion, rad."""
    slow, fast = 0.0015 * math.sin(0.3 * k), 5e-5 * math.sin(1.1 * k)
    return BEGIN + 0.0005 * k + slow + fast


def goal(k: int) -> float:
    """A goal that moves: angle of cycle k, rad."""
    return 0.2 + 0.001 * math.sin(0.25 * k) + 2e-5 * math.sin(1.3 * k)


def said(
    state: str,
    mode: str,
    angle: float,
    second: float | None = None,
    *,
    r: float = 0.0,
    p: float = 0.0,
    **more: Any,
) -> Cycle:
    """One cycle's set-point."""
    numbers = {"angle": angle, "r": r, "p": p, **({} if second is None else {"second": second})}
    rounded = {name: round(value, 9) for name, value in numbers.items()}
    return {"state": state, "mode": mode, **rounded, **more}


def reaching(
    before: int, after: int, transition: int, between: int, lost: tuple[int, ...] = ()
) -> Trace:
    """Out of rest along a curve, soon over to a goal that moves; only its begin is looked at."""
    cycles = [said("IDLE", "JOINT", BEGIN, BEGIN) for _ in range(4)]
    t_acc = before * PERIOD_S
    cycles.append(said("START", "CARTESIAN", BEGIN, r=1.0, acceleration_time=t_acc))
    for k in range(1, transition + 1):
        second = goal(k) if k > transition - 15 else None
        cycles.append(said("BLEND", "CARTESIAN", curve(k), second, r=1.0, p=k / transition))
    for k in range(transition + 1, transition + between + 1):
        cycles.append(said("PRE", "CARTESIAN", curve(k), goal(k), r=1.0))
    k = transition + between + 1
    t_acc = after * PERIOD_S
    start = said("START", "JOINT", curve(k), goal(k), r=1.0, acceleration_time=t_acc)
    cycles.append(start)
    for n in range(1, 6):
        r, p = 1.0 - 1e-4 * n * n, n / (2.0 * after)
        cycles.append(said("BLEND", "JOINT", goal(k + n), r=r, p=p))
    for n in lost:
        cycles[n]["omit"] = ["SETPOINT"]
    name = f"transition of {after} after one of {before} cycles, {between} between"
    name += f", {len(lost)} lost" if lost else ""
    return trace(name, cycles, begin=BEGIN)


FAR: Final = 2.0**-6
"""A goal, rad: exact in float32, as is half of the way, so that equal is equal."""
RESTS: Final = (
    # how far from the goal the joint is at p = 1, rad; where it is told to be at rest
    ("within 1e-6 rad of the goal", 0.6e-6, FAR - 0.002),
    ("1.4e-6 rad from the goal", 1.4e-6, FAR - 0.002),
    ("nearer to where it was than to the goal", FAR / 2.0, 0.6 * FAR),
    ("in the middle", FAR / 2.0, 0.75 * FAR),
    ("nearer to the goal", FAR / 2.0, 0.9 * FAR),
)


def resting(where: str, away: float, rest: float) -> Trace:
    """A goal that moves, left by r short of it at p = 1; one cycle of rest, and a motion again.

    Whether the history of the goal goes on decides on the rate at the hand-over.
    """
    cycles = [said("IDLE", "JOINT", 0.0, FAR) for _ in range(4)]
    left = away / FAR
    cycles.append(said("START", "JOINT", 0.0, FAR, r=1.0, acceleration_time=T_ACC))
    for k in range(1, 41):
        p = k / 40.0
        r = 1.0 - (1.0 - left) * p * p * (3.0 - 2.0 * p)
        cycles.append(said("BLEND", "JOINT", FAR + 2.0**-12 * (1.0 - p), r=r, p=p))
    cycles.append(said("IDLE", "JOINT", rest, 0.03, r=left))
    return trace(f"one cycle of rest {where}", [*cycles, *departing(rest, 0.03)], begin=0.0)


def departing(at: float, to: float, ticks: int = 20) -> list[Cycle]:
    """The begin of a joint segment."""
    t_acc = ticks * PERIOD_S
    cycles = [said("START", "JOINT", at, to, r=1.0, acceleration_time=t_acc)]
    for k in range(1, 8):
        cycles.append(said("BLEND", "JOINT", to, r=1.0 - 1e-3 * k * k, p=k / (2.0 * ticks)))
    return cycles


def leaving(blended: bool, lost: tuple[int, ...]) -> Trace:
    """A joint segment left by a Cartesian transition, ``blended`` to the end, then a motion on."""
    cycles = [said("IDLE", "JOINT", BEGIN, 0.15) for _ in range(12)]
    cycles += departing(BEGIN, 0.15)
    r: float = cycles[-1]["r"]
    here, first = 0.15 + r * (BEGIN - 0.15), len(cycles)

    def hand(k: int) -> float:
        return here + curve(k) - BEGIN

    for k in range(1, 21):
        p = k / 20.0 if blended or k < 9 else 0.0
        cycles.append(said("LINEAR", "CARTESIAN", hand(k), goal(k), r=r, p=p))
    for k in lost:
        cycles[k]["omit"] = ["SETPOINT"]
    name = f"a joint segment left on a line, {'blended' if blended else 'then straight'}"
    name += f", {len(lost)} set-points lost" if lost else ""
    assert all(first <= k < len(cycles) for k in lost)
    return trace(name, [*cycles, *departing(hand(21), goal(21))], begin=BEGIN)


def arrived() -> list[Cycle]:
    """r comes to 0 at a goal that moves: its history goes on at rest."""
    cycles = [said("IDLE", "JOINT", BEGIN, BEGIN + 0.01) for _ in range(4)]
    cycles += departing(BEGIN, BEGIN + 0.01)
    for k in range(14):
        r = 0.951 * (1.0 - k / 13.0)
        cycles.append(said("LINEAR", "JOINT", curve(k) + 0.01, r=r))
    cycles += [said("IDLE", "JOINT", curve(k) + 0.01, goal(k)) for k in (14, 15)]
    return [*cycles, *departing(curve(16) + 0.01, goal(16))]


def lost_at_rest() -> list[Cycle]:
    """At rest a pose that moves, one that is lost, and one where the joint was before it."""
    cycles = [said("IDLE", "JOINT", curve(k), goal(k)) for k in range(12)]
    at = cycles[-1]["angle"]
    cycles += [{"omit": ["SETPOINT"]}, said("IDLE", "JOINT", at, goal(13))]
    return [*cycles, *departing(at, goal(14))]


def lost_after_start() -> list[Cycle]:
    """START of a joint segment out of another, one that is lost, and START again."""
    cycles = [said("IDLE", "JOINT", BEGIN, 0.15) for _ in range(12)]
    cycles += departing(BEGIN, 0.15)
    r: float = cycles[-1]["r"]
    for k in range(1, 12):
        cycles.append(said("LINEAR", "JOINT", 0.15, 0.16, r=r - 0.01 * k))
    at = 0.15 - 0.05 * (r - 0.12)
    cycles += [
        said("START", "JOINT", at, 0.16, r=1.0, acceleration_time=T_ACC),
        {"omit": ["SETPOINT"]},
        said("LINEAR", "JOINT", 0.16, 0.14, r=0.98),
    ]
    return [*cycles, *departing(0.16 + 0.97 * (at - 0.16), 0.14)]


LINE: Final = [
    said("LINEAR", "CARTESIAN", curve(k), goal(k), r=0.9, p=k / 20.0) for k in range(1, 21)
]
"""A Cartesian transition."""
AGAIN: Final[dict[str, list[Cycle]]] = {
    "a joint segment at once": departing(BEGIN, 0.15),
    "a Cartesian segment at once": [
        said("START", "CARTESIAN", BEGIN, r=1.0, acceleration_time=T_ACC),
        *(said("BLEND", "CARTESIAN", curve(k), r=1.0, p=k / 40.0) for k in range(1, 8)),
    ],
    "a Cartesian transition, and on": [*LINE, *departing(curve(21), goal(21), 190)],
    "a set-point that is lost, and on": [
        {"omit": ["SETPOINT"]},
        *(said("IDLE", "JOINT", curve(k), goal(k)) for k in range(1, 4)),
        {"omit": ["SETPOINT"]},
        *departing(curve(5), goal(5)),
    ],
}
"""What comes first after a START that is not the first."""


def again(name: str, cycles: list[Cycle], earlier: int) -> Trace:
    """Stopped in a long transition, or before it, and enabled again: nothing of it is left."""
    before = reaching(400, 190, 40, 3)["cycles"]
    before = before[: len(before) - earlier]
    stop: list[Cycle] = [{"command": "STOP", "sync": "READY"}, {}]
    first = {"command": "START", "sync": "OPERATIONAL", **cycles[0]}
    return trace(f"enabled again: {name}", [*before, *stop, first, *cycles[1:]], begin=BEGIN)
