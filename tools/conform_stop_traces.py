"""Inputs of the traces that home a joint, stop it, and take its set-points away."""

from typing import Any, Final

from conform_law_traces import (
    AS_THE_BENCH,
    MIRRORED,
    PERIOD_S,
    Cycle,
    Trace,
    codes,
    counts,
    held,
    moved,
    run_up,
    slowing,
    trace,
)

SPEED: Final = 0.4
"""HOMING_SPEED of the bench, rad/s."""
INTERVAL: Final = 0.125
"""Between two indexes, rad."""


def traces() -> list[Trace]:
    """All of them."""
    return [*homings(), *holds(), *stops(), *failings()]


def homings() -> list[Trace]:
    """From below and from above, the index at once and later, then START."""
    return [
        homing("homing upwards", -0.9, 1.0),
        homing("homing downwards", 0.9, -1.0),
        homing("homing, the index seen before", -0.4, 1.0, travel=0),
        homing("homing on a mirrored board", -0.9, 1.0, changes=MIRRORED),
        homing("homing, the joint behind its set-point", -0.6, 1.0, lag=0.004),
        homing("homing, the coarse position off", 0.5, -1.0, off=0.024),
    ]


def homing(
    name: str,
    begin: float,
    direction: float,
    travel: int = 40,
    lag: float = 0.0,
    off: float = 0.0,
    changes: dict[str, float] | None = None,
) -> Trace:
    """The joint moves until its index comes; it is held; it is enabled."""
    cycles: list[Cycle] = [
        {"sync": "HOMING", "command": "HOME", "measured": begin, "coarse": begin + off},
        *held(2),
    ]
    at = begin
    for k in range(travel):
        at += direction * SPEED * PERIOD_S
        behind = direction * lag * min(1.0, k / 10.0)
        measured = counts(at - behind)
        cycles.append(
            {"measured": measured, "coarse": measured + off, "speed": codes(direction * SPEED)}
        )
    last = cycles[-1].get("measured", begin)
    cycles.append({"index": counts(round(last / INTERVAL) * INTERVAL)})
    last = counts(last + 0.001 * direction)
    cycles += [*held(4, speed=0.0), *held(3, measured=last), *held(2, sync="READY")]
    cycles.append({"command": "START", "sync": "OPERATIONAL", "angle": last})
    cycles += [*held(3), *held(3, measured=counts(last + 0.002))]
    return {**trace(name, cycles, changes, begin=begin), "from": "PREOP"}


def holds() -> list[Trace]:
    """Held as after homing: after a motion, and after a pause in which the joint was moved."""
    motion = moved(run_up(0.6, 40), 0.001)
    cycles: list[Cycle] = [*motion, {"command": "STOP", "sync": "READY", "speed": 0.0}, *held(3)]
    for begin in (0.22, 0.25):
        there = counts(begin)
        cycles += [{"measured": there, "coarse": there}, {"sync": "HOMING"}, *held(4)]
        cycles += [{"measured": counts(there + 0.002)}, *held(3), {"sync": "READY"}, *held(2)]
    return [trace("held after operation, where it is", cycles, begin=0.1)]


def stops() -> list[Trace]:
    """QUICKSTOP out of motion and out of rest; where it comes to rest it holds."""
    return [
        stop("stop of a motion upwards", 1.4),
        stop("stop of a motion downwards", -1.4),
        stop("stop of a slow motion", 0.02),
        stop("stop at rest", 0.0),
        stop("stop before the end of the range", 1.4, 2.58),
        stop("stop before the other end", -1.4, -2.33),
        stop("stop at the very end of the range", 0.055, 2.74997 - way(0.055)),
        stop("stop, pushed away in time", 0.5, push=60),
        stop("stop, pushed away later", 0.5, push=150),
        stop("stop with a displacement", 0.6, comply=0.002),
        stop("stop with gravity and inertia", 1.0, rows={"gravity": 1.5, "inertia_row": [0.1] * 6}),
    ]


def way(speed: float) -> float:
    """How far a run up to a speed takes the set-point, rad."""
    *_, (angle, _) = run_up(speed, 24, 0.0)
    return angle


def stop(name: str, speed: float, begin: float = 0.1, push: int = 0, **inputs: Any) -> Trace:
    """Up to a speed, QUICKSTOP, and on until it has settled; the joint lags a little."""
    motion = moved(run_up(speed, 24, begin), 0.001)
    motion[0].update(inputs)
    cycles = [*motion, {"command": "QUICKSTOP", "sync": "QUICKSTOP"}]
    braking = slowing(motion[-1]["measured"], speed, 190 if push else 90)
    for cycle in braking[push:] if push else ():
        cycle["measured"] = counts(cycle["measured"] + 0.003)
    return trace(name, [*cycles, *braking], begin=begin)


def failings() -> list[Trace]:
    """Frames that do not come, rung by rung."""
    silent = [{"omit": ["SETPOINT"], "speed": codes(0.5 - 0.04 * k)} for k in range(30)]
    blind = [{"omit": ["MEASURE"]} for _ in range(6)]
    deaf = [{"omit": ["ERROR 2"]} for _ in range(5)]
    rows = {"gravity": 1.2}
    start = moved(run_up(0.6, 20))
    on = moved(run_up(0.6, 30))[20:]
    away = [{**c, "measured": counts(c["angle"] - 0.05)} for c in on[:4]]
    steps = {**on[0], "angle": on[0]["angle"] + 0.3}
    return [
        trace("SETPOINT lost for good", [{"rows": rows}, *start, *silent, *held(3)], begin=0.1),
        trace(
            "SETPOINT lost, fast",
            [
                {"rows": rows},
                *start,
                *[
                    {"omit": ["SETPOINT"], "speed": codes(v)}
                    for v in (0.5, 0.5, 0.5, 0.5, 0.5, 2.4, -2.4, 0.3, -0.3)
                ],
            ],
            begin=0.1,
        ),
        trace("SETPOINT lost once", [*start, {"omit": ["SETPOINT"]}, *on[1:]], begin=0.1),
        trace(
            "SETPOINT lost twice",
            [*start, {"omit": ["SETPOINT"]}, {"omit": ["SETPOINT"]}, *on[2:]],
            begin=0.1,
        ),
        trace("MEASURE lost for good", [{"rows": rows}, *start, *blind], begin=0.1),
        trace("MEASURE lost twice", [*start, *blind[:2], *on[2:]], begin=0.1),
        trace("ERROR lost for good", [{"rows": rows}, *start, *deaf, *held(8)], begin=0.1),
        trace("ERROR lost twice", [*start, *deaf[:2], *on[2:]], begin=0.1),
        trace("two cycles skipped", [*start, {**on[2], "skip": 2}, *on[3:]], begin=0.1),
        trace(
            "an encoder that jumps once",
            [*start, {**on[0], "measured": counts(on[0]["angle"] + 0.05)}, *on[1:]],
            AS_THE_BENCH,
            begin=0.1,
        ),
        trace(
            "an encoder that jumps for good",
            [*start, *away, *slowing(away[-1]["measured"], 0.6, 20)],
            AS_THE_BENCH,
            begin=0.1,
        ),
        trace(
            "a set-point that steps",
            [*start, steps, *slowing(on[0]["measured"], 0.6, 20)],
            AS_THE_BENCH,
            begin=0.1,
        ),
    ]
