"""A random program: joint, Cartesian and mixed moves, by way of the places where arms fail.

Targets are drawn as joint angles, so that each has a solution in the configuration it is asked for;
whether the way there can be made is for the planner to say. ``MIX`` is the declared mix.
"""

import math
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np

from rfms_can.arm import Arm
from rfms_can.kinematics import Joints, configuration_of, direct, singularity_margins
from rfms_can.messages.functions import AnyFunction, Circular, Linear, Weave
from rfms_can.transform import Transform

MIX: Final = {
    "anywhere": 0.34,
    "near": 0.22,
    "wrist": 0.14,
    "elbow": 0.06,
    "shoulder": 0.06,
    "range end": 0.08,
    "half turn": 0.10,
}
"""Where a move goes: anywhere in the ranges; near where the arm is; to or next to a singularity; to
an end of a range; by half a turn of joint 4 or 6."""
MIX_NUMBER: Final = 2
"""Changes with the way programs are drawn, so that results of two ways are not mixed."""
MOVES: Final = (2, 4)
"""Fewest and most moves of a program."""
CARTESIAN: Final = 0.3
"""Part of the moves that are straight lines."""
MOVING: Final = 0.12
"""Part of the goals that move by themselves."""
GENTLE: Final = 0.88
"""Part of the modes that let a segment be lengthened."""
VIA: Final = 0.5
"""Part of the moves that are asked for before the one before is complete."""
JOINT_COORDINATES: Final = 0.25
"""Part of the moves in joint mode to a goal at rest that are asked for by joint angles."""
PACES: Final = 0.15
"""Part of the moves under which feed rate or pause change."""

_ZERO: Final[Joints] = (0.0,) * 6
_OFFSETS: Final = (0.0, 0.0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.05)
"""How far from a singularity or an end of a range a target is, rad."""


class Move(NamedTuple):
    """A move of a random program.

    Attributes:
        kind: where it goes; of ``MIX``.
        target: T6 where its goal does not move by itself.
        configuration: of the target.
        function: that the goal moves by, or None.
        mode: settings of its mode, by the names of ``ModeMessage``.
        waits: whether the next one is asked for when this one is complete.
        after: cycles after which the next one is asked for where it does not wait.
        pace: cycles after its request, and the feed rate from then on; 0 is a pause of a second.
        angles: its target in joint coordinates, rad, where it is asked for by these; or None.
    """

    kind: str
    target: Transform
    configuration: str
    function: AnyFunction | None
    mode: dict[str, Any]
    waits: bool
    after: int
    pace: tuple[int, float] | None
    angles: Joints | None = None


class Program(NamedTuple):
    """Where the arm stands at first (rad), and the moves."""

    start: Joints
    moves: list[Move]


def draw(arm: Arm, seed: int) -> Program:
    """The program of a seed; the same for ever.

    What is asked for in joint coordinates has random numbers of its own: but for that, programs are
    what they were before.
    """
    rng, joint_rng = np.random.default_rng(seed), np.random.default_rng((seed, 1))
    q = start = _anywhere(rng, arm)
    moves = []
    for _ in range(int(rng.integers(MOVES[0], MOVES[1] + 1))):
        kind = str(rng.choice(list(MIX), p=list(MIX.values())))
        straight = bool(rng.random() < CARTESIAN)
        there: Joints = _KINDS[kind](rng, arm, q)
        if straight and kind in ("anywhere", "half turn"):
            there = _near(rng, arm, q)
        there = _within(arm, there)
        if straight and configuration_of(arm, there) != configuration_of(arm, q):
            there = _flipped_like(arm, there, q)
        function = _function(rng) if rng.random() < MOVING else None
        by_angles = joint_rng.random() < JOINT_COORDINATES and not straight and function is None
        pace = None
        if rng.random() < PACES:
            pace = (int(rng.integers(1, 400)), float(rng.choice([0.0, 0.3, 0.6, 1.0])))
        moves.append(
            Move(
                kind,
                direct(arm, there),
                str(configuration_of(arm, there)),
                function,
                _mode(rng, straight),
                bool(rng.random() > VIA),
                int(rng.integers(0, 250)),
                pace,
                there if by_angles else None,
            )
        )
        q = there
    return Program(start, moves)


def _mode(rng: np.random.Generator, straight: bool) -> dict[str, Any]:
    settings: dict[str, Any] = {"interpolation": "cartesian" if straight else "joint"}
    if straight and rng.random() < 0.3:
        settings["transition"] = "cartesian"
    time = float(rng.uniform(0.4, 2.0))
    settings["acceleration_time"] = float(rng.uniform(0.1, 0.4) * time)
    if rng.random() < 0.6:
        settings["segment_time"] = time
    elif straight:
        settings["speed"] = float(rng.uniform(0.02, 0.3))
    else:
        settings["joint_speed"] = float(rng.uniform(0.1, 1.0))
    settings["lengthen"] = bool(rng.random() < GENTLE)
    return settings


def _function(rng: np.random.Generator) -> AnyFunction:
    direction = rng.normal(size=3)
    x, y, z = (direction / np.linalg.norm(direction) * rng.uniform(0.001, 0.01)).tolist()
    drawn: list[AnyFunction] = [
        Linear(along=(x, y, z), parameter="h"),
        Weave((x / 2, y / 2, z / 2), float(rng.uniform(0.2, 1.0)), "t"),
        Weave((x, y, z), float(rng.integers(1, 4)), "h"),
        Circular(float(rng.uniform(0.001, 0.01)), 2.0 * math.pi, parameter="h"),
    ]
    return drawn[int(rng.integers(4))]


# --- where to ------------------------------------------------------------------------------------


def _anywhere(rng: np.random.Generator, arm: Arm, _q: Joints = _ZERO) -> Joints:
    return _joints([rng.uniform(lower, upper) for lower, upper in arm.joint_limits])


def _near(rng: np.random.Generator, arm: Arm, q: Joints) -> Joints:
    size = rng.uniform(0.05, 0.6)
    return _joints(np.add(q, rng.uniform(-size, size, 6)))


def _offset(rng: np.random.Generator) -> float:
    return float(rng.choice(_OFFSETS) * rng.choice([-1.0, 1.0]))


def _wrist(rng: np.random.Generator, arm: Arm, q: Joints) -> Joints:
    return _replaced(_near(rng, arm, q), 5, _offset(rng))


def _elbow(rng: np.random.Generator, arm: Arm, q: Joints) -> Joints:
    stretched = math.atan2(-arm.d4, arm.a3)  # the margin's sine vanishes here
    angle = stretched if rng.random() < 0.5 else stretched + math.pi
    return _replaced(_near(rng, arm, q), 3, math.remainder(angle, math.tau) + _offset(rng))


def _shoulder(rng: np.random.Generator, arm: Arm, q: Joints) -> Joints:
    there = _near(rng, arm, q)
    q2 = there[1]
    for _ in range(20):  # Newton: the wrist centre above the joint-1 axis
        margin = singularity_margins(arm, _replaced(there, 2, q2)).shoulder
        slope = singularity_margins(arm, _replaced(there, 2, q2 + 1e-6)).shoulder - margin
        if abs(slope) < 1e-12:
            break
        q2 -= float(np.clip(1e-6 * margin / slope, -0.3, 0.3))
    return _replaced(there, 2, q2 + _offset(rng))


def _range_end(rng: np.random.Generator, arm: Arm, q: Joints) -> Joints:
    there = _near(rng, arm, q)
    joint = int(rng.integers(1, 7))
    lower, upper = arm.joint_limits[joint - 1]
    inside = abs(_offset(rng))
    return _replaced(there, joint, lower + inside if rng.random() < 0.5 else upper - inside)


def _half_turn(rng: np.random.Generator, arm: Arm, q: Joints) -> Joints:
    joint = int(rng.choice([4, 6]))
    turn = math.pi * float(rng.choice([-1.0, 1.0])) + _offset(rng)
    return _replaced(_near(rng, arm, q), joint, q[joint - 1] + turn)


_KINDS: Final[dict[str, Callable[[np.random.Generator, Arm, Joints], Joints]]] = {
    "anywhere": _anywhere,
    "near": _near,
    "wrist": _wrist,
    "elbow": _elbow,
    "shoulder": _shoulder,
    "range end": _range_end,
    "half turn": _half_turn,
}


def _flipped_like(arm: Arm, there: Joints, q: Joints) -> Joints:
    """``there`` with the branches of ``q``: a straight line cannot change them."""
    wanted = configuration_of(arm, q)
    for _ in range(8):
        if configuration_of(arm, there) == wanted:
            return there
        there = _joints([(a + b) / 2.0 for a, b in zip(there, q, strict=True)])
    return q


def _within(arm: Arm, q: Joints) -> Joints:
    return _joints(
        [
            min(max(angle, lower), upper)
            for angle, (lower, upper) in zip(q, arm.joint_limits, strict=True)
        ]
    )


def _replaced(q: Joints, joint: int, angle: float) -> Joints:
    return _joints([angle if k == joint - 1 else other for k, other in enumerate(q)])


def _joints(values: Any) -> Joints:
    q1, q2, q3, q4, q5, q6 = (float(value) for value in values)
    return (q1, q2, q3, q4, q5, q6)
