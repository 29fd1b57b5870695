"""The excitation motions: sweeps and bursts of each joint, without and with the known load.

Poses come from Table 4.2 and Eq. 4.26 to 4.29 of the thesis as corrected, converted to convention B
(``dynamics/terms.py``), and moved by up to ``ASIDE`` at the end of a range or at a singularity: the
analysis uses the measured angles, not the commanded ones.
"""

import random
from collections.abc import Sequence
from dataclasses import dataclass
from math import radians
from typing import Final

from rfms_can.arm import JOINT_COUNT, Arm
from rfms_can.dynamics.terms import from_convention_a
from rfms_can.identification.experiments.actions import (
    Action,
    Burst,
    Creep,
    Pose,
    Sweep,
    Tour,
    with_joint,
)
from rfms_can.kinematics import singularity_margins

ASIDE: Final = radians(6.0)
MARGIN: Final = radians(3.0)
"""Distance from the end of a joint's range, rad."""
WRIST: Final = (0.3, -1.2, 0.2)
"""theta4 to theta6, rad, where they do not matter: away from the wrist's singularity."""

SHAPES_D11_DEG: Final = (
    *((-195, 75), (-165, 135), (-90, 30), (-90, 135)),
    *((0, 0), (0, 90), (30, 220)),
)
"""theta2, theta3 in convention A, degrees: four of the well-conditioned set, three of Eq. 4.29."""
SHAPES_D22_DEG: Final = (0.0, 180.0, 90.0, 45.0)
"""theta3 likewise: Eq. 4.28, and one more."""
SHAPES_D33_DEG: Final = (90.0, 10.0, -60.0)
"""theta5: Eq. 4.27, and one more; at 0 the wrist is singular."""
SHAPES_D44_DEG: Final = (90.0, 15.0)
"""theta5: Eq. 4.26, likewise."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """Actions from one power-up to the next.

    Attributes:
        name: of its data.
        load: whether the known load is in the hand.
        actions: in order.
    """

    name: str
    load: bool
    actions: tuple[Action, ...]


def pose_at(arm: Arm, two_deg: float, three_deg: float, wrist: Sequence[float] = WRIST) -> Pose:
    """theta2 and theta3 of convention A, degrees, as a pose the arm can take, rad."""
    q = list(from_convention_a((0.0, radians(two_deg), radians(three_deg), *wrist)))
    q[0], q[3:] = 0.0, wrist
    for joint in (1, 2):
        lower, upper = arm.joint_limits[joint]
        q[joint] = min(max(q[joint], lower + MARGIN), upper - MARGIN)
    if abs(singularity_margins(arm, q).elbow) < 0.1:
        q[2] += ASIDE
    return tuple(q)  # type: ignore[return-value]


def experiments(arm: Arm) -> tuple[Experiment, ...]:
    """All experiments for an arm; five or six minutes of its time."""
    return (
        Experiment("creep", False, _creeps(arm)),
        Experiment("sweep-1", False, (_sweep(arm, 1, _PARKED, 0.35), _sweep(arm, 1, _PARKED, 0.7))),
        *_sweeps(arm, 2, ((0.0, 180.0), (0.0, 0.0)), WRIST, (0.9, 0.6), (0.9, 0.8)),
        *_sweeps(arm, 3, ((0.0, 0.0), (-90.0, 0.0)), WRIST, (0.8, 0.45), (0.7, 0.6)),
        *_sweeps(arm, 4, ((-90.0, 180.0), (-90.0, 0.0)), _SIDEWAYS, (0.5, 0.2), (0.4, 0.3)),
        *_sweeps(arm, 5, ((-90.0, 0.0), (-90.0, 90.0)), _SIDEWAYS, (0.5, 0.2), (0.4, 0.3)),
        *_sweeps(arm, 6, ((-90.0, 180.0), (-90.0, 0.0)), _LEVEL, (0.5, 0.2), (0.4, 0.3)),
        Experiment("burst-1-load", True, tuple(_stretched(arm))),
        Experiment("burst-1", False, (*_stretched(arm), *_bursts_1(arm))),
        Experiment("burst-2", False, tuple(_bursts_2(arm))),
        Experiment("burst-3", False, tuple(_bursts_3(arm))),
        Experiment("burst-wrist", False, tuple(_bursts_wrist(arm))),
        Experiment("tour-1", False, (_tour(arm, 1, 14),)),
        Experiment("tour-2", False, (_tour(arm, 2, 6),)),
    )


_PARKED: Final = (-90.0, 30.0)
_SIDEWAYS: Final = (0.0, radians(90.0), 0.0)
"""theta5 = 90: a load in the hand exerts a torque on joint 4, and on joint 5 as it sweeps."""
_LEVEL: Final = (radians(90.0), radians(90.0), 0.0)
"""theta4 = theta5 = 90 with a level forearm: the axis of joint 6 is level too."""

Shape = tuple[float, float]


def _sweeps(
    arm: Arm,
    joint: int,
    shapes: tuple[Shape, Shape],
    wrist: Sequence[float],
    bare: tuple[float, float],
    loaded: tuple[float, float],
) -> tuple[Experiment, Experiment]:
    """Sweeps of one joint at two poses, without and with the load; speeds over its limit."""

    def actions(fractions: tuple[float, float]) -> tuple[Action, ...]:
        pairs = zip(shapes, fractions, strict=True)
        return tuple(_sweep(arm, joint, shape, fraction, wrist) for shape, fraction in pairs)

    return (
        Experiment(f"sweep-{joint}", False, actions(bare)),
        Experiment(f"sweep-{joint}-load", True, actions(loaded)),
    )


def _sweep(
    arm: Arm, joint: int, shape: Shape, fraction: float, wrist: Sequence[float] = WRIST
) -> Sweep:
    """A sweep over a range large enough to identify the gravity torque."""
    i = joint - 1
    lower, upper = (
        limit + side * MARGIN for limit, side in zip(arm.joint_limits[i], (1.0, -1.0), strict=True)
    )
    middle, half = _TRAVEL[i]
    lower, upper = max(lower, middle - half), min(upper, middle + half)
    return Sweep(joint, pose_at(arm, *shape, wrist), lower, upper, fraction * arm.speed_limits[i])


_TRAVEL: Final = ((0.0, 1.0), (1.6, 1.8), (-1.75, 1.85), (0.0, 1.5), (0.0, 1.6), (0.0, 1.5))
"""Middle and half width of a sweep, rad; less than half a turn to either side of a goal."""


def _creeps(arm: Arm) -> tuple[Action, ...]:
    """Each joint so slowly that the torque rises little between two samples at breakaway."""
    pose = arm.park
    return tuple(
        Creep(joint, pose, pose[joint - 1], pose[joint - 1] + CREEP_DISTANCE, CREEP_SPEED)  # type: ignore[arg-type]
        for joint in range(1, JOINT_COUNT + 1)
    )


CREEP_DISTANCE: Final = 0.014
CREEP_SPEED: Final = 0.008
"""rad and rad/s."""


def _stretched(arm: Arm) -> list[Action]:
    """Joint 1 with the load at full reach: its inertia is the known quantity."""
    pose = pose_at(arm, -180.0, 90.0, (0.0, 0.2, 0.0))
    return [Burst(1, with_joint(pose, 1, -0.5), 1.0, 3)]


def _bursts_1(arm: Arm) -> list[Action]:
    return [
        Burst(1, with_joint(pose_at(arm, *shape), 1, -0.45), 0.9, 1) for shape in SHAPES_D11_DEG
    ]


def _bursts_2(arm: Arm) -> list[Action]:
    poses = (pose_at(arm, -90.0, three) for three in SHAPES_D22_DEG)
    return [Burst(2, with_joint(pose, 2, radians(90.0) - 0.4), 0.8, 1) for pose in poses]


def _bursts_3(arm: Arm) -> list[Action]:
    poses = (pose_at(arm, -90.0, 45.0, (0.0, radians(five), 0.0)) for five in SHAPES_D33_DEG)
    return [Burst(3, pose, 0.6, 2) for pose in poses]


def _bursts_wrist(arm: Arm) -> list[Action]:
    bent, *others = (
        pose_at(arm, -90.0, 45.0, (0.0, radians(five), 0.0)) for five in SHAPES_D44_DEG
    )
    return [
        *(Burst(4, pose, 0.8, 2) for pose in (bent, *others)),
        Burst(5, with_joint(bent, 5, 0.4), 0.8, 2),
        Burst(6, bent, 0.8, 2),
    ]


TOUR_SPEED: Final = 0.9
TOUR_ACCELERATION_S: Final = 0.18


def _tour(arm: Arm, seed: int, places: int) -> Tour:
    """Random poses around the park pose, far from singularities."""
    draw = random.Random(seed)
    found: list[Pose] = []
    while len(found) < places:
        q = [
            draw.uniform(max(lower + MARGIN, -2.6), min(upper - MARGIN, 2.6))
            for lower, upper in arm.joint_limits
        ]
        q[1] = draw.uniform(0.7, 2.4)
        q[2] = draw.uniform(-3.4, 0.3)
        q[4] = draw.choice((-1.0, 1.0)) * draw.uniform(0.3, 1.5)
        margins = singularity_margins(arm, q)
        if abs(margins.elbow) > 0.3 and abs(margins.shoulder) > 0.2 * arm.a2:
            found.append(tuple(q))  # type: ignore[arg-type]
    return Tour(tuple(found), TOUR_SPEED, TOUR_ACCELERATION_S)


def fast_tour(arm: Arm) -> Tour:
    """Motion for the comparison of compensations: poses of no experiment."""
    return _tour(arm, 3, 5)
