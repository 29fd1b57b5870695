"""A servoing run drawn from a seed: a part, its way, and the observations of a camera."""

import math
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np

from rfms_can.arm import Arm
from rfms_can.kinematics import Joints, configuration_of, direct, inverse
from rfms_can.transform import Transform

RUN_S: Final = 4.0
"""How long the arm is watched, s; two seconds of it, at least, after the last observation."""
LATEST_SILENCE_S: Final = 2.5
OUTLIERS: Final = 0.03
"""Part of the observations that show something else, up to a metre away."""
OUTLIER_M: Final = 1.0
LOSS: Final = 0.3
LEVER_M: Final = 0.2
"""Distance at which noise of a rotation is noise of a point."""
LATENCY_S: Final = (0.01, 0.03)
NOISES: Final = (0.0, 0.0002, 0.0005, 0.001, 0.002)
RATES_HZ: Final = (25, 50, 100, 250, 500)

Path = Callable[[float], Transform]
"""Where the part is, as a displacement of T6 in its own frame, at a time, s."""


class Scene(NamedTuple):
    """A run.

    Attributes:
        kind: of the part's way; of ``WAYS``.
        start: joint angles at which the hand is at the part at first, rad.
        path: of the part.
        predict: how the reference goes on between observations.
        rate: of the camera, Hz.
        noise: standard deviation of a coordinate, m.
        jitter: of the times of pictures, part of the interval.
        silent_from: the time of the last observation, s.
        observations: when each arrives and was taken, s, and what it shows, by arrival.
    """

    kind: str
    start: Joints
    path: Path
    predict: str
    rate: int
    noise: float
    jitter: float
    silent_from: float
    observations: list[tuple[float, float, Transform]]


def draw(arm: Arm, seed: int) -> Scene:
    """The run of a seed; the same for ever."""
    rng = np.random.default_rng(seed)
    kind = str(rng.choice(list(WAYS)))
    start = _somewhere(rng, arm, kind)
    path = WAYS[kind](rng)
    rate, noise = int(rng.choice(RATES_HZ)), float(rng.choice(NOISES))
    jitter = float(rng.choice([0.0, 0.5, 1.0]))
    silent_from = float(rng.uniform(1.2, LATEST_SILENCE_S))
    predict = str(rng.choice(["hold", "velocity"]))
    pose = direct(arm, start)
    observations = []
    for k in range(math.ceil(silent_from * rate)):
        taken = max(0.0, (k + jitter * rng.uniform(-0.5, 0.5)) / rate)
        seen = pose @ path(taken) @ _noise(rng, noise)
        if rng.random() < OUTLIERS:
            x, y, z = rng.uniform(-OUTLIER_M, OUTLIER_M, 3).tolist()
            seen = Transform.translation(x, y, z) @ seen
        if rng.random() >= LOSS:
            observations.append((taken + float(rng.uniform(*LATENCY_S)), taken, seen))
    observations.sort(key=lambda each: each[0])
    settings = (predict, rate, noise, jitter, silent_from)
    return Scene(kind, start, path, *settings, observations)


def _noise(rng: np.random.Generator, size: float) -> Transform:
    x, y, z = (rng.normal(size=3) * size).tolist()
    turn = rng.normal(size=3) * size / LEVER_M
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return Transform.translation(x, y, z)
    a, b, c = (turn / angle).tolist()
    return Transform.translation(x, y, z) @ Transform.rotation((a, b, c), angle)


def _somewhere(rng: np.random.Generator, arm: Arm, kind: str) -> Joints:
    """A place with room around it; near the wrist singularity for a way that goes through it."""
    while True:
        q = [float(angle + rng.uniform(-0.4, 0.4)) for angle in arm.park]
        q[4] = float(rng.uniform(0.15, 0.4) if kind == "through the wrist" else rng.uniform(0.7, 1))
        start = (q[0], q[1], q[2], q[3], q[4], q[5])
        pose = direct(arm, start)
        try:
            inverse(arm, pose, configuration_of(arm, start), start)
        except Exception:
            continue
        return start


# --- ways ----------------------------------------------------------------------------------------


def _still(rng: np.random.Generator) -> Path:
    return lambda _: Transform.identity()


def _direction(rng: np.random.Generator) -> tuple[float, float, float]:
    direction = rng.normal(size=3)
    x, y, z = (direction / np.linalg.norm(direction)).tolist()
    return (x, y, z)


def _belt(rng: np.random.Generator) -> Path:
    speed = float(rng.uniform(0.01, 0.08))
    x, y, z = _direction(rng)

    def path(time: float) -> Transform:
        way = speed * min(time, 1.5)
        return Transform.translation(x * way, y * way, z * way)

    return path


def _swing(rng: np.random.Generator) -> Path:
    width, rate = float(rng.uniform(0.005, 0.03)), float(rng.uniform(0.2, 0.8))
    x, y, z = _direction(rng)

    def path(time: float) -> Transform:
        way = width * (1.0 - math.cos(2.0 * math.pi * rate * time))
        return Transform.translation(x * way, y * way, z * way)

    return path


def _turn(rng: np.random.Generator) -> Path:
    axis, speed = _direction(rng), float(rng.uniform(0.1, 0.4))
    return lambda time: Transform.rotation(axis, speed * min(time, 2.0))


def _through_the_wrist(rng: np.random.Generator) -> Path:
    """The hand's approach direction tips over that of the forearm, a little beside it."""
    beside, speed = float(rng.uniform(-0.1, 0.1)), float(rng.uniform(0.2, 0.6))
    sense = float(rng.choice([-1.0, 1.0]))
    length = math.hypot(beside, 1.0)
    axis = (beside / length, sense / length, 0.0)
    return lambda time: Transform.rotation(axis, speed * time)


def _away(rng: np.random.Generator) -> Path:
    """Out of reach, in time."""
    speed = float(rng.uniform(0.1, 0.3))
    x, y, z = _direction(rng)
    return lambda time: Transform.translation(x * speed * time, y * speed * time, z * speed * time)


def _jumps(rng: np.random.Generator) -> Path:
    at, size = float(rng.uniform(0.6, 1.2)), float(rng.uniform(0.01, 0.08))
    x, y, z = _direction(rng)

    def path(time: float) -> Transform:
        way = size if time >= at else 0.0
        return Transform.translation(x * way, y * way, z * way)

    return path


WAYS: Final[dict[str, Callable[[np.random.Generator], Path]]] = {
    "still": _still,
    "belt": _belt,
    "swing": _swing,
    "turn": _turn,
    "through the wrist": _through_the_wrist,
    "away": _away,
    "jumps": _jumps,
}
"""How a part may go."""
