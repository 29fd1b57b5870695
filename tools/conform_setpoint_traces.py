"""Inputs of the golden set-point traces: what a master says of one joint's motion, state by state.

A little master of one joint: its goals are angles, a Cartesian segment is a curve between two. The
joint stands where it is told to be as far as whole counts allow, and does not move by itself: what
is asked is ERROR.
"""

import math
from collections.abc import Callable
from typing import Any, Final

import conform_history_traces
from conform_law_traces import PERIOD_S, Cycle, Trace, trace

T_ACC: Final = 0.08
T_SEG: Final = 0.36
Curve = Callable[[float], float]
"""Angle of a Cartesian segment by h, from 0 (its start) to 1."""


def traces() -> list[Trace]:
    """All of them."""
    found: list[Trace] = []
    for blend in ("CONTINUOUS", "THESIS"):
        found += [
            journey(
                f"joint, joint, {blend}", blend, ("JOINT", 0.25), ("JOINT", 0.05), ("JOINT", 0.2)
            ),
            journey(
                f"Cartesian, Cartesian, {blend}", blend, ("CARTESIAN", 0.22), ("CARTESIAN", 0.1)
            ),
            journey(
                f"joint, Cartesian, joint, {blend}",
                blend,
                ("JOINT", 0.2),
                ("CARTESIAN", 0.05),
                ("JOINT", 0.15),
            ),
            journey(f"Cartesian, joint, {blend}", blend, ("CARTESIAN", 0.0), ("JOINT", 0.2)),
            journey(
                f"a goal that moves, {blend}", blend, ("JOINT", 0.2), ("JOINT", 0.1), drift=0.0002
            ),
            journey(
                f"a feed rate of 0.7, {blend}",
                blend,
                ("JOINT", 0.2),
                ("CARTESIAN", 0.1),
                ("JOINT", 0.2),
                feed=0.7,
            ),
            journey(f"PRE lost, {blend}", blend, ("JOINT", 0.2), ("JOINT", 0.1), pre=0),
            journey(
                f"PRE of many cycles, {blend}",
                blend,
                ("CARTESIAN", 0.2),
                ("CARTESIAN", 0.1),
                pre=40,
            ),
            journey(
                f"set-points lost, {blend}",
                blend,
                ("JOINT", 0.2),
                ("CARTESIAN", 0.1),
                lost=(8, 30, 31, 60, 80, 99, 111),
            ),
            journey(
                f"set-points lost before a hand-over, {blend}",
                blend,
                ("CARTESIAN", 0.2),
                ("CARTESIAN", 0.1),
                ("JOINT", 0.2),
                lost=(96, 97, 99, 185, 188, 189),
                drift=0.0003,
            ),
        ]
    return [
        *found,
        slow(300, 1.2, "transition of 300 cycles"),
        slow(1400, 5.6, "transition of 1400 cycles"),
        slow(2800, 11.2, "transition of 2800 cycles"),
        slow(256, 1.024, "transition of 256 cycles"),
        slow(257, 1.028, "transition of 257 cycles"),
        slow(1401, 5.604, "transition of 1401 cycles"),
        slow(1500, 6.0, "transition of 1500 cycles"),
        slow(2801, 11.204, "transition of 2801 cycles"),
        slow(3000, 12.0, "transition of 3000 cycles"),
        *(young(n) for n in (0, 1, 2, 3, 7, 8, 9, 10, 11)),
        journey(
            "hand-overs one soon after the other",
            "CONTINUOUS",
            ("CARTESIAN", 0.3),
            ("CARTESIAN", 0.1),
            ("JOINT", 0.25),
            times=(0.2, 0.42),
            pre=3,
        ),
        *(late(blend) for blend in ("CONTINUOUS", "THESIS")),
        *transitions(),
        *rests(),
        *conform_history_traces.traces(),
    ]


class Master:
    """Says where a joint shall go, cycle by cycle."""

    def __init__(self, begin: float, blend: str, drift: float = 0.0, pre: int = 12) -> None:
        self.cycles: list[Cycle] = []
        self.at = begin
        self.blend = blend
        self.drift = drift
        self.wave = 0.0
        self.pre = pre
        self.t_acc, self.t_seg = T_ACC, T_SEG
        self.k = 0

    def say(self, state: str, mode: str, q1: float, q2: float | None = None, **more: Any) -> None:
        """One cycle."""
        self.k += 1
        moved = self.drift * self.k + self.wave * math.sin(0.9 * self.k)
        cycle: Cycle = {"state": state, "mode": mode, "angle": round(q1 + moved, 7)}
        if q2 is not None:
            cycle["second"] = round(q2 + moved, 7)
        told = {k: round(v, 7) if isinstance(v, float) else v for k, v in more.items()}
        self.cycles.append({**cycle, "blend": self.blend, **told})

    def rest(self, count: int, second: float | None = None) -> None:
        """IDLE where the last goal is."""
        for _ in range(count):
            self.say("IDLE", "JOINT", self.at, second, r=0.0, p=0.0)

    def segment(self, mode: str, goal: float, following: float | None, feed: float) -> None:
        """From -t_acc to t_seg - t_acc; ``following``: where the next one starts from, as T6_1."""
        begin, t_acc, t_seg, tick = self.at, self.t_acc, self.t_seg, PERIOD_S * feed
        curve = path(begin, goal)
        elapsed = 0.0 if feed == 1.0 else 0.35 * tick
        time = -t_acc + elapsed
        scaled = t_acc / feed
        p = elapsed / (2.0 * t_acc)
        if mode == "JOINT":
            self.say(
                "START",
                mode,
                begin,
                goal,
                r=1.0 - h_of(time, t_seg, t_acc),
                p=p,
                acceleration_time=scaled,
            )
        else:
            self.say(
                "START",
                mode,
                begin,
                r=1.0 - h_of(time, t_seg, t_acc),
                p=p,
                acceleration_time=scaled,
            )
        time += tick
        while time < t_seg - t_acc - 1e-9:
            p = min(1.0, (time + t_acc) / (2.0 * t_acc))
            h = h_of(time, t_seg, t_acc)
            q1 = goal if mode == "JOINT" else curve(h)
            left = round((t_seg - t_acc - time) / tick)
            if time < t_acc - 1e-9:
                self.say("BLEND", mode, q1, r=1.0 - h, p=p)
            elif left <= self.pre and following is not None:
                self.say("PRE", mode, q1, following, r=1.0 - h, p=0.0)
            else:
                self.say("LINEAR", mode, q1, r=1.0 - h, p=0.0)
            time += tick
        self.at = goal


def h_of(time: float, t_seg: float, t_acc: float) -> float:
    """The segment parameter: (3.15) of the thesis up to t_acc, then linear."""
    if time >= t_acc:
        return time / t_seg
    p = max(0.0, (time + t_acc) / (2.0 * t_acc))
    return t_acc / t_seg * ((2.0 * p - 6.0) * p + 5.0) * p**4


def path(begin: float, goal: float) -> Curve:
    """A curve between two angles, as a joint follows a straight line of the hand."""
    return lambda h: begin + (goal - begin) * h + 0.03 * h * (1.0 - h) * (1.0 + 0.5 * h)


def journey(
    name: str,
    blend: str,
    *legs: tuple[str, float],
    drift: float = 0.0,
    feed: float = 1.0,
    pre: int = 12,
    lost: tuple[int, ...] = (),
    rest: int = 12,
    times: tuple[float, float] = (T_ACC, T_SEG),
    wave: float = 0.0,
) -> Trace:
    """Some segments one after the other, and to rest at the last goal."""
    master = Master(0.1, blend, drift, pre)
    master.wave = wave
    master.t_acc, master.t_seg = times
    legs = (*legs, ("JOINT", legs[-1][1]))  # the last one comes to rest
    # what the next segment is solved from: its goal, or where its curve begins
    before = (0.1, *(goal for _, goal in legs))
    starts = [
        goal if mode == "JOINT" else begin
        for (mode, goal), begin in zip(legs, before[:-1], strict=True)
    ]
    master.rest(rest, starts[0])
    for (mode, goal), following in zip(legs, (*starts[1:], None), strict=True):
        master.segment(mode, goal, following, feed)
    master.rest(4)
    for k in lost:
        master.cycles[k]["omit"] = ["SETPOINT"]
    return trace(name, master.cycles, begin=0.1)


def young(cycles: int) -> Trace:
    """A goal that moves, left after so many cycles: there are as many samples of it, no more.

    It moves on no polynomial of low degree, so fits of different degrees differ.
    """
    name = f"a goal that moves, left after {cycles} cycles"
    found = journey(name, "CONTINUOUS", ("JOINT", 0.15), drift=0.0004, rest=cycles, wave=0.0002)
    return {**found, "cycles": found["cycles"][: cycles + 48]}


def slow(ticks: int, t_acc: float, name: str) -> Trace:
    """A transition that is long; it is looked at here and there only."""
    master = Master(0.1, "CONTINUOUS")
    master.rest(12, 0.1)

    def curve(h: float) -> float:
        """No polynomial of low degree: long and short windows differ on it."""
        return path(0.1, 0.2)(h) + 0.003 * math.sin(100.0 * h)

    h = 0.0
    master.say("START", "CARTESIAN", 0.1, r=1.0, p=0.0, acceleration_time=0.1)
    for k in range(1, 51):
        p = min(1.0, k / 50.0)
        h = 0.002 * k * p
        master.say("BLEND", "CARTESIAN", curve(h), r=1.0 - h, p=p)
    for k in range(140):
        h = 0.1 + 0.002 * k
        state = "PRE" if k > 100 else "LINEAR"
        goal = 0.25 + 0.001 * math.sin(0.15 * k)
        master.say(state, "CARTESIAN", curve(h), goal, r=1.0 - h, p=0.0)
    goal = 0.25 + 0.001 * math.sin(0.15 * 140)
    master.say("START", "JOINT", curve(h + 0.002), goal, r=1.0, p=0.0, acceleration_time=t_acc)
    for k in range(1, 16):
        master.say("BLEND", "JOINT", 0.25, r=1.0 - 0.0001 * k * k, p=k / (2.0 * ticks))
    return trace(name, master.cycles, begin=0.1)


def late(blend: str) -> Trace:
    """A hand-over of which a fifth has passed when START comes."""
    master = Master(0.1, blend)
    master.rest(12, 0.1)
    master.segment("CARTESIAN", 0.3, 0.35, 1.0)
    h = 1.0 - master.cycles[-1]["r"] + PERIOD_S / T_SEG
    begin = path(0.1, 0.3)(h)
    master.say("START", "JOINT", begin, 0.35, r=0.999, p=0.2, acceleration_time=T_ACC)
    for k in range(9, 41):
        p = k / 40.0
        r = 1.0 - h_of(2.0 * T_ACC * p - T_ACC, T_SEG, T_ACC)
        master.say("BLEND", "JOINT", 0.35, r=r, p=p)
    return trace(f"a late hand-over, {blend}", master.cycles, begin=0.1)


def transitions() -> list[Trace]:
    """A Cartesian transition: LINEAR with p, out of rest and out of a joint segment."""
    found = []
    for blend in ("CONTINUOUS", "THESIS"):
        master = Master(0.1, blend)
        master.rest(6)
        for k in range(1, 41):
            p = k / 40.0
            master.say("LINEAR", "CARTESIAN", 0.1 + 0.06 * p**3, r=1.0 - p, p=p)
        master.at = 0.16
        master.rest(3, 0.25)
        master.segment("JOINT", 0.25, None, 1.0)
        found.append(trace(f"Cartesian transition out of rest, {blend}", master.cycles, begin=0.1))
        master = Master(0.1, blend)
        master.rest(12, 0.3)
        master.segment("JOINT", 0.3, None, 1.0)
        # the hand goes on from where the joint was: 0.3 + r (0.1 - 0.3)
        r = master.cycles[-1]["r"]
        here, step = 0.3 - 0.2 * r, 0.2 * PERIOD_S / T_SEG
        for k in range(1, 41):
            master.say("LINEAR", "CARTESIAN", here + step * k, r=r, p=k / 40.0)
        begin = here + step * 41 + 0.002  # a step that START must not hide
        master.say("START", "JOINT", begin, begin + 0.1, r=1.0, p=1.0, acceleration_time=T_ACC)
        for k in range(1, 20):
            h = step * k / 0.1
            master.say("LINEAR", "JOINT", begin + 0.1, r=1.0 - h, p=0.0)
        found.append(
            trace(f"Cartesian transition of a joint segment, {blend}", master.cycles, begin=0.1)
        )
    return found


def rests() -> list[Trace]:
    """Stopped on the way, held in a transition; then a motion again."""
    found = []
    for blend in ("CONTINUOUS", "THESIS"):
        stopped = Master(0.1, blend)
        stopped.rest(12, 0.3)
        stopped.segment("JOINT", 0.3, None, 1.0)
        r = stopped.cycles[-1]["r"]
        for k in range(40):
            r -= 0.011 * math.exp(-k / 6.0)
            stopped.say("LINEAR", "JOINT", 0.3, r=r, p=0.0)
        stopped.at = 0.3 - 0.2 * r
        for _ in range(14):
            stopped.say("IDLE", "JOINT", stopped.at, 0.2, r=0.4, p=0.0)
        stopped.segment("JOINT", 0.2, None, 1.0)
        found.append(trace(f"stopped before its goal, {blend}", stopped.cycles, begin=0.1))
        held = Master(0.1, blend)
        held.rest(12, 0.1)
        held.segment("CARTESIAN", 0.2, 0.3, 1.0)
        held.say("START", "JOINT", 0.2, 0.3, r=1.0, p=0.0, acceleration_time=T_ACC)
        for k in range(1, 16):
            p = min(k, 12) / 40.0
            held.say(
                "BLEND", "JOINT", 0.3, r=1.0 - h_of(2.0 * T_ACC * p - T_ACC, T_SEG, T_ACC), p=p
            )
        held.at = 0.195
        held.rest(4, 0.25)
        held.segment("JOINT", 0.25, None, 1.0)
        found.append(trace(f"held in a transition, {blend}", held.cycles, begin=0.1))
    return found
