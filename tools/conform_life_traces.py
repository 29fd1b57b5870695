"""Inputs of the traces that begin again: START after STOP, RESET and HOME, and lives at random.

What a joint remembers shows only when it begins again. A life is homed, enabled, disturbed, stopped
and homed again; the draws are made by seed, what comes of them is recorded.
"""

import random
from typing import Any, Final

from conform_law_traces import (
    COMPLYING,
    MIRRORED,
    NO_FRICTION,
    PERIOD_S,
    RIGID,
    WEIGHTED,
    WEIGHTED_COMPLYING,
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
MIDDLE: Final = 0.125
"""Of the bench's range, rad; and the distance of two indexes."""
LIVES: Final = 5
ROWS: Final = (RIGID, COMPLYING, WEIGHTED, WEIGHTED_COMPLYING)
CHANGES: Final[tuple[dict[str, float], ...]] = (
    {},
    MIRRORED,
    {"PERIOD": 0.005, "DITHER_FRACTION": 0.5},
    {"KI": 4000.0, "INTEGRAL_LIMIT": 4.0},
    {"TORQUE_LIMIT": 3.0, "INTEGRAL_LIMIT": 1.0, "CONTINUOUS_TORQUE": 1.0},
)


def traces() -> list[Trace]:
    """All of them."""
    return [*restarts(), *stops(), *(life(seed) for seed in range(1, LIVES + 1))]


def restarts() -> list[Trace]:
    """START after STOP: without integral, friction, transfer, displacement or bias of before."""
    still = [{"command": "STOP", "sync": "READY", "speed": 0.0}, *held(2)]
    start: Cycle = {"command": "START", "sync": "OPERATIONAL", "others": [[0.0, 0.0, 0.0]] * 5}
    comply = {**COMPLYING, "gravity": 0.0}
    wound = held(40, measured=counts(0.1 - 0.008))
    moving = moved(run_up(0.8, 24))
    at = moving[-1]["angle"]
    rows = {"rows": {**comply, "gravity": 0.1}}
    again = {"rows": {**comply, "gravity": 0.2}}
    return [
        trace("START after a wound integral", [*wound, *still, start, *held(6)], begin=0.1),
        trace(
            "START after a motion",
            [*moving, *still, {**start, "angle": at}, *held(3), *held(4, measured=counts(at))],
            {"KP": 0.0, "KI": 0.0, "KD": 0.0},
            begin=0.1,
        ),
        *(
            trace(
                f"START {cycles} cycles after compliance began",
                [*moving[:20], rows, *held(cycles), *still, {**start, **again}, *held(40)],
                {**changes, "DITHER_FRACTION": 0.6},
                begin=0.1,
            )
            for cycles in (2, 40)
            for changes in ({}, NO_FRICTION)
        ),
        trace(
            "START after a displacement and a bias",
            [
                {"comply": 0.004, "bias": 1.5},
                *held(4),
                *still,
                {**start, "comply": 0.001, "bias": None},
                *held(3),
                {"comply": None},
                *held(2),
            ],
            begin=0.1,
        ),
        trace(
            "START after a SETPOINT that was lost",
            [*held(3), {"omit": ["SETPOINT"]}, {"omit": ["SETPOINT"]}, *still, start, *held(3)],
            begin=0.1,
        ),
    ]


def stops() -> list[Trace]:
    """Stops that are commanded twice, and a joint that comes to rest as the time for it ends."""
    motion = moved(run_up(1.0, 24), 0.001)
    at = motion[-1]["measured"]
    stop: Cycle = {"command": "QUICKSTOP", "sync": "QUICKSTOP"}
    twice = [*motion, stop, *slowing(at, 1.0, 10), {"command": "QUICKSTOP"}, *held(12)]
    # 25 cycles after the ramp a joint may choose where it rests; twelve still ones are asked for
    found = [trace("a stop that is commanded twice", twice, begin=0.1)]
    for still_from in (11, 12, 13, 14, 15):
        creeping = [{"measured": counts(0.1 - 0.0005 * k)} for k in range(1, still_from + 1)]
        cycles = [*held(3), stop, *creeping, *held(20)]
        name = f"a stop in which the joint creeps for {still_from} cycles"
        found.append(trace(name, cycles, {"PERIOD": 0.02}, begin=0.1))
    return found


# --- lives ----------------------------------------------------------------------------------------


def life(seed: int) -> Trace:
    """A joint that is homed, enabled and stopped several times, and disturbed meanwhile."""
    changes = CHANGES[seed % len(CHANGES)]
    drawn = _Life(random.Random(seed), 0.12 * changes.get("TORQUE_LIMIT", 10.0))
    cycles = drawn.lived()
    return {**trace(f"life {seed}", cycles, changes, begin=drawn.begin), "from": "PREOP"}


class _Life:
    """Draws the cycles of a life, and knows where its joint is.

    Args:
        draw: where the draws come from.
        load: largest gravity, Nm: two of them differ by no more than a joint takes for a load.

    Attributes:
        begin: where the joint was at first, rad.
    """

    def __init__(self, draw: random.Random, load: float) -> None:
        self._draw = draw
        self._load = load
        self.begin = self._at = counts(draw.uniform(-1.2, 1.2))
        self._specification = 0
        self._out: list[Cycle] = []

    def lived(self) -> list[Cycle]:
        """Three times from HOME to RESET."""
        for _ in range(3):
            self._home()
            for _ in range(self._draw.randrange(1, 4)):
                self._start()
                if self._operate():
                    break  # something was lost for too long: RESET is needed
                self._stop()
            self._reset()
        return self._out

    def _say(self, cycles: int = 1, **inputs: Any) -> None:
        self._out += held(cycles, **inputs)

    def _rows(self) -> Cycle:
        """A set that no set before was."""
        self._specification += self._draw.randrange(2)
        gravity = round(self._draw.uniform(-self._load, self._load), 4)
        return {
            **self._draw.choice(ROWS),
            "gravity": gravity,
            "specification": self._specification,
        }

    def _home(self) -> None:
        draw = self._draw
        at = self._at
        gravity = round(draw.uniform(-self._load, self._load), 4)
        begin: Cycle = {
            **{"command": "HOME", "sync": "HOMING", "measured": at, "coarse": at, "speed": 0.0},
            **{"rows": {"gravity": gravity}, "comply": None, "bias": None},
            "others": [[0.0, 0.0, 0.0]] * 5,
        }
        self._out.append(begin)
        up = 1.0 if at < MIDDLE else -1.0
        for _ in range(draw.randrange(2, 14)):
            at = counts(at + up * draw.uniform(0.6, 1.2) * SPEED * PERIOD_S)
            speed = codes(up * draw.uniform(0.2, 0.5))
            missed = ["REFERENCE"] if draw.random() < 0.1 else []
            self._say(measured=at, coarse=at, speed=speed, omit=missed)
        if draw.random() < 0.5:
            self._say(2, sync="READY", speed=0.0)
            at = counts(at + draw.uniform(-0.01, 0.01))
            self._say(3, sync="HOMING", measured=at, coarse=at)
        self._say(index=counts(round(at / MIDDLE) * MIDDLE), speed=0.0)
        at = counts(at + 0.0005 * up)
        self._say(draw.randrange(1, 5), measured=at, coarse=at)
        self._at = at

    def _start(self) -> None:
        others = [[round(self._draw.uniform(-0.01, 0.01), 4), 0.0, 0.0] for _ in range(5)]
        begin: Cycle = {
            **{"command": "START", "sync": "OPERATIONAL", "angle": self._at, "index": None},
            **{"rows": self._rows(), "others": others, "speed": 0.0},
        }
        self._out.append(begin)

    def _operate(self) -> bool:
        """A motion or a rest with what goes wrong meanwhile; whether it has stopped the joint."""
        draw = self._draw
        cycles = draw.randrange(12, 30)
        speed = draw.choice((0.0, 0.3, -0.3, 0.8, -0.8))
        motion = moved(run_up(speed, cycles, self._at), 0.0)
        if speed == 0.0:
            motion = [{"measured": self._at, "speed": 0.0} for _ in range(cycles)]
        wrong = draw.choice((self._lost, self._jumps, self._changes, self._changes))
        at = draw.randrange(4, cycles)
        for number, cycle in enumerate(motion):
            self._at = cycle["measured"]
            lag = counts(draw.uniform(-0.002, 0.002))
            self._say(**{**cycle, "measured": counts(self._at + lag)})
            if number == at and wrong():
                return True
        return False

    def _lost(self) -> bool:
        """Frames that do not come, for some cycles."""
        what = self._draw.choice(("SETPOINT", "MEASURE", "ERROR 1", "ERROR 4"))
        cycles = self._draw.choice((1, 2, 2, 3, 6, 8))
        for _ in range(cycles):
            self._say(omit=[what], speed=codes(self._draw.uniform(-0.2, 0.2)))
        if cycles > 2:
            self._say(self._draw.randrange(2, 20))
        return cycles > 2

    def _jumps(self) -> bool:
        """An encoder that jumps, and comes back or does not."""
        cycles, there = self._draw.choice((1, 2, 4)), self._at
        back = -0.8 if there > 0.0 else 0.8
        for number in range(1, cycles + 1):
            self._say(measured=counts(there + back * number))
        if cycles > 2:
            self._say(self._draw.randrange(16, 24), speed=0.0)
        return cycles > 2

    def _changes(self) -> bool:
        """Other rows, displacements, biases and errors; numbers of SYNC that are left out."""
        draw = self._draw
        self._say(rows=self._rows())
        self._say(comply=draw.choice((None, 0.001, -0.002)), bias=draw.choice((None, 0.8, -1.1)))
        self._say(others=[[0.0, round(draw.uniform(-0.2, 0.2), 3), 1.5] for _ in range(5)])
        self._say(skip=draw.randrange(3))
        return False

    def _stop(self) -> None:
        """STOP, and perhaps held."""
        self._say(
            2, command="STOP", sync="READY", measured=self._at, speed=0.0, comply=None, bias=None
        )
        if self._draw.random() < 0.5:
            self._at = counts(self._at + self._draw.uniform(-0.05, 0.05))
            self._say(2, measured=self._at, coarse=self._at)
            self._say(self._draw.randrange(2, 6), sync="HOMING")
            self._say(2, sync="READY")

    def _reset(self) -> None:
        """QUICKSTOP if it is still enabled, and on for a while; then RESET."""
        last = self._out[-1]
        if last.get("sync") != "READY":
            sync = self._draw.choice(("QUICKSTOP", "OPERATIONAL"))
            self._say(self._draw.randrange(2, 30), command="QUICKSTOP", sync=sync, speed=0.0)
            if self._draw.random() < 0.5:
                self._say(3, command="QUICKSTOP")
        self._say(2, command="RESET", sync="PREOP", rows={"gravity": 0.001 * len(self._out)})
