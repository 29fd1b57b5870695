"""Poses that ``rfms conform`` asks of one joint, with the angles that the third node finds.

Arms of other shapes up to the ends of their reach, wrists that are almost straight, and poses at
the ends of a joint's range.
"""

import math
import random
from collections.abc import Sequence
from typing import Any, Final

from third_node import kinematics
from third_node.codec import float32
from third_node.configuration import NUMBER, Geometry

from rfms_can.arm import PUMA_260
from rfms_can.kinematics import SphericalWrist, configuration_of, direct
from rfms_can.transform import Transform
from rfms_can.wire.configuration import DhRow, geometry_values
from rfms_can.wire.nodes import JOINTS

Pose = dict[str, Any]
Entry = dict[str, Any]

SEED: Final = 1987
MICRO: Final = 1e-6
"""A micrometre in metres: the tolerance of the reach."""
SHAPES: Final = (
    # a2, a3, d4, d2, d3 in micrometres
    (300_000, 50_000, 200_000, 40_000, -90_000),
    (180_000, -30_000, 310_000, 0, 120_000),
    (250_000, 0, 250_000, 0, 0),
    (200_001, 0, 200_000, 1, 0),
)
"""Arms whose links differ, whose forearm is bent either way, whose shoulder is on either side; one
that can fold onto its shoulder, and one that almost can."""
REGULAR: Final = 6
"""Random poses of each shape."""


def told(pose: Transform, configuration: int) -> Entry:
    """A pose as SETPOINT carries it."""
    return {
        "o": [float32(x) for x in (pose.ox, pose.oy, pose.oz)],
        "a": [float32(x) for x in (pose.ax, pose.ay, pose.az)],
        "p": [float32(x) for x in (pose.px, pose.py, pose.pz)],
        "configuration": configuration,
    }


def angles_of(geometry: Geometry, entry: Entry, held: kinematics.Held) -> list[float | None]:
    """The six angles of a pose up to whole turns; null where a joint has none."""
    parts = (entry["o"], entry["a"], entry["p"])
    code, found = entry["configuration"], []
    for joint in JOINTS:
        own = kinematics.Held()
        own.c4, own.s4 = held.c4, held.s4
        found.append(kinematics.solve(joint, geometry, *parts, code, own))
        last = own
    held.c4, held.s4 = last.c4, last.s4  # joints 4, 5 and 6 hold the same
    return found


# --- arms of other shapes -------------------------------------------------------------------------


def shapes() -> list[dict[str, Any]]:
    """Arms, and poses of each."""
    draw = random.Random(SEED)
    return [_shape(draw, *shape) for shape in SHAPES]


def _shape(draw: random.Random, a2: int, a3: int, d4: int, d2: int, d3: int) -> dict[str, Any]:
    rows = [DhRow(0.0, 0.0, math.radians(angle)) for angle in (90, 0, -90, 90, -90, 0)]
    rows[1] = DhRow(a2 / 1e6, d2 / 1e6, rows[1].alpha)
    rows[2] = DhRow(a3 / 1e6, d3 / 1e6, rows[2].alpha)
    rows[3] = DhRow(0.0, d4 / 1e6, rows[3].alpha)
    values = {p.name: value for p, value in geometry_values(tuple(rows)).items()}
    geometry = Geometry({NUMBER[name]: value for name, value in values.items()})
    arm = SphericalWrist.of(tuple(rows), ((-4.0, 4.0),) * 6, "a shape")
    turned = direct(arm, [draw.uniform(-2.0, 2.0) for _ in JOINTS])
    codes = list(range(8))
    draw.shuffle(codes)
    poses = [direct(arm, [draw.uniform(-3.0, 3.0) for _ in JOINTS]) for _ in range(REGULAR)]
    poses += [_at(turned, *place) for place in _borders(arm)]
    entries = [told(pose, codes[n % 8]) for n, pose in enumerate(poses)]
    for entry in entries:
        entry["angles"] = angles_of(geometry, entry, kinematics.Held())
    return {"geometry": values, "poses": entries}


def _borders(arm: SphericalWrist) -> list[tuple[float, float, float]]:
    """Wrist centres half a micrometre on either side of where the reach ends, and on its way there.

    Each as radius from the axis of joint 1, height, and angle about that axis.
    """
    d, forearm = abs(arm.shoulder_offset), math.hypot(arm.a3, arm.d4)
    nearest, farthest = abs(arm.a2 - forearm), arm.a2 + forearm
    shoulder, near = max(d - MICRO, MICRO), max(nearest - MICRO, MICRO)
    some = 0.5 * (nearest + farthest)
    places = [(shoulder + off * MICRO, some, 0.7) for off in (-0.5, 0.5)]
    places += [(0.0, some, 0.0), (shoulder + 1.5 * MICRO, -some, 2.7)]
    for rho in (near - 0.5 * MICRO, near + 0.5 * MICRO, near + 1e-4, near + 0.02):
        places += [_from_shoulder(d, rho, part, turn) for part, turn in ((0.6, -1.1), (-0.8, 2.1))]
    for rho in (farthest + 1.5 * MICRO, farthest + 0.5 * MICRO, farthest - 1e-4):
        places += [_from_shoulder(d, rho, part, turn) for part, turn in ((0.6, 0.4), (-0.8, -2.5))]
    return places


def _from_shoulder(d: float, rho: float, part: float, turn: float) -> tuple[float, float, float]:
    """A wrist centre rho from the shoulder, ``part`` of it upwards."""
    height = part * rho
    radius = math.sqrt(d * d + rho * rho - height * height)
    return radius, height, turn


def _at(pose: Transform, radius: float, height: float, turn: float) -> Transform:
    return pose._replace(px=radius * math.cos(turn), py=radius * math.sin(turn), pz=height)


# --- wrists that are almost straight --------------------------------------------------------------

LEFT_UP: Final = 0
ARM: Final = (0.3, 0.7, -2.0)
"""Joints 1 to 3 where the wrist is straight."""
OUT_OF_REACH: Final = 3.0
"""What a position is multiplied with to be out of reach."""


def _wrist(q4: float, q5: float, q6: float = 0.5, arm: Sequence[float] = ARM) -> Pose:
    q = (*arm, q4, q5, q6)
    return told(direct(PUMA_260, q), configuration_of(PUMA_260, q).code)


def _far(entry: Pose) -> Pose:
    return {**entry, "p": [float32(OUT_OF_REACH * x) for x in entry["p"]]}


STRAIGHT: Final = _wrist(-2.9, 0.4e-5, 0.2, (0.5, 0.6, -1.8))
"""A straight wrist: joint 4 is where it was."""


def wrists() -> list[Entry]:
    """Wrists one after the other, from COMMIT on: what each leaves decides on the next.

    ``how`` says how a pose is told: alone; with ``second``; after a new start, a RESET, or a
    COMMIT; with joint 4 told; in a set-point that is refused, or cannot be reached.
    """
    steps: list[Entry] = [{**_wrist(0.4, 0.8e-5), "how": "alone"}]
    for q4, q5 in (
        (0.4, 1.3e-5),
        (-0.7, 1e-4),
        (1.9, 1e-3),
        (0.9, -1.3e-5),
        (-1.8, -3e-4),
        (1.2, math.pi - 1.3e-5),
        (2.5, math.pi + 2e-5),
    ):
        steps += [{**_wrist(q4, q5), "how": "alone"}, {**STRAIGHT, "how": "alone"}]
        steps.append({**_wrist(0.1 - q4, math.copysign(0.8e-5, q5)), "how": "alone"})
    steps.append({**_wrist(0.6, math.pi - 0.8e-5), "how": "alone"})
    bent = [_wrist(q4, q5) for q4, q5 in ((1.1, 0.4), (-1.4, -0.5), (0.3, 0.6), (-2.2, 0.7))]
    for how, first, second in (
        ("out of reach", _far(bent[0]), None),
        ("alone", bent[0], bent[1]),
        ("refused", bent[2], None),
        ("out of reach", bent[3], _far(bent[0])),
        ("alone", bent[1], STRAIGHT),
        ("told", STRAIGHT, None),
        ("restarted", STRAIGHT, None),
        ("reset", STRAIGHT, None),
        ("configured", STRAIGHT, None),
    ):
        steps.append({**first, "how": how} | ({} if second is None else {"second": second}))
        steps.append({**STRAIGHT, "how": "alone"})
    return _solved_in_turn(steps)


TOLD: Final = float32(1.7)
"""Joint 4 where it is told, rad."""


def _solved_in_turn(steps: list[Entry]) -> list[Entry]:
    links = tuple(DhRow(a, d, alpha) for alpha, a, d in PUMA_260.dh)
    geometry = Geometry({NUMBER[p.name]: v for p, v in geometry_values(links).items()})
    held = kinematics.Held()
    for step in steps:
        if step["how"] == "configured":
            held = kinematics.Held()
        if step["how"] == "told":
            step["joint_4"] = TOLD
            held.set_angle(TOLD)
        step["angles"] = angles_of(geometry, step, held)
        if "second" in step:
            seconds = angles_of(geometry, step["second"], held)
            both = zip(step["angles"], seconds, strict=True)
            step["angles"] = [None if second is None else first for first, second in both]
        if step["how"] == "refused":
            step["angles"] = [None] * len(JOINTS)
    return steps


# --- the ends of a joint's range ------------------------------------------------------------------


def ends(rest: Sequence[float], low: float, high: float) -> dict[str, list[Entry]]:
    """Of each joint, poses half of the margin beyond its range, and more than all of it."""
    links = tuple(DhRow(a, d, alpha) for alpha, a, d in PUMA_260.dh)
    geometry = Geometry({NUMBER[p.name]: v for p, v in geometry_values(links).items()})
    found: dict[str, list[Entry]] = {}
    for joint in JOINTS:
        entries = found[str(joint)] = []
        for end, sign in ((low, -1.0), (high, 1.0)):
            for beyond in (0.5e-5, 1.5e-5):
                q = list(rest)
                q[joint - 1] = end + sign * beyond
                entry = told(direct(PUMA_260, q), configuration_of(PUMA_260, q).code)
                angle = angles_of(geometry, entry, kinematics.Held())[joint - 1]
                assert angle is not None, "a pose within reach"
                entries.append({**entry, "angle": kinematics.nearest_turn(angle, end, low, high)})
    return found
