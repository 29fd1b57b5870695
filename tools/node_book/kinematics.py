"""Vectors of the inverse solution: poses as they travel, and the six joints' angles."""

import math
import random
from typing import Final

from generated import table

from node_book.printed import as_float32, number
from node_book.pump import PERIOD_S
from rfms_can.arm import PUMA_260, PUMA_560, Arm
from rfms_can.joint_nodes.angle_solver import AngleSolver
from rfms_can.kinematics import WIRE, Configuration, JointSolver, SphericalWrist, direct
from rfms_can.kinematics.configuration import CONFIGURATIONS
from rfms_can.kinematics.geometry import Joints
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.transform import Transform
from rfms_can.wire.configuration import DhRow, geometry_rows, geometry_values
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import JointAngles
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

SEED: Final = 1986
ARMS: Final = (PUMA_260, PUMA_560)
Q: Final[Joints] = (0.4, 0.7, -1.9, 0.8, -1.1, 0.3)
"""Joint angles of the first pose, rad."""
WIDE: Final = ((-10.0, 10.0),) * 6
"""Ranges that leave out no branch, rad."""


def geometry(arm: Arm) -> SphericalWrist:
    """An arm as a node has it, by what CONFIG carries."""
    values = geometry_values(tuple(DhRow(a, d, alpha) for alpha, a, d in arm.dh))
    return SphericalWrist.of(geometry_rows(values), WIDE, arm.name)


def sent(pose: Transform) -> tuple[float, ...]:
    """o, a and p of a pose as SETPOINT carries them."""
    elements = (pose.ox, pose.oy, pose.oz, pose.ax, pose.ay, pose.az, pose.px, pose.py, pose.pz)
    return tuple(as_float32(x) for x in elements)


def received(elements: tuple[float, ...]) -> Transform:
    """The pose that a node makes of nine float32."""
    return Transform.from_o_a_p(elements[0:3], elements[3:6], elements[6:9])


def solve(
    arm: SphericalWrist, pose: Transform, configuration: Configuration, held: float = 0.0
) -> tuple[float, ...]:
    """The angles that six nodes make of a pose, from previous angles of 0."""
    angles = []
    for joint in JOINTS:
        solver = JointSolver(arm, joint, WIRE)
        solver.hold(held)
        angles.append(solver.solve(pose, configuration, 0.0))
    return tuple(angles)


def _angles(angles: tuple[float, ...]) -> tuple[str, ...]:
    return tuple("NaN" if math.isnan(a) else f"{a:.9f}" for a in angles)


_COLUMNS: Final = ("arm", "o", "a", "p, m", "code", *(f"θ{j}" for j in JOINTS))


def _row(arm: Arm, elements: tuple[float, ...], code: int) -> tuple[str, ...]:
    o, a, p = (", ".join(number(x, 9) for x in elements[i : i + 3]) for i in (0, 3, 6))
    angles = solve(geometry(arm), received(elements), CONFIGURATIONS[code])
    return (arm.name, o, a, p, str(code), *_angles(angles))


def _said(elements: tuple[float, ...]) -> str:
    o, a, p = (", ".join(number(x, 9) for x in elements[i : i + 3]) for i in (0, 3, 6))
    return f"```\no = {o}\na = {a}\np = {p}\n```\n\n"


def branches() -> str:
    """One pose in all eight branches."""
    elements = sent(direct(PUMA_260, Q))
    rows = [_row(PUMA_260, elements, code)[4:] for code in range(8)]
    return _said(elements) + table(_COLUMNS[4:], rows)


def poses() -> str:
    """Random poses of both arms in random branches, and poses without a solution."""
    rng = random.Random(SEED)
    rows = []
    for index in range(8):
        arm = ARMS[index % 2]
        q1, q2, q3, q4, q5, q6 = (rng.uniform(-3.0, 3.0) for _ in JOINTS)
        elements = sent(direct(arm, (q1, q2, q3, q4, q5, q6)))
        rows.append(_row(arm, elements, rng.randrange(8)))
    far = (0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    for place in ((0.5, 0.0, 0.0), (0.05, 0.05, 0.2), (0.0, 0.0, 0.0)):
        rows.append(_row(PUMA_260, (*far, *(as_float32(x) for x in place)), 0))
    crooked = (0.0, 1.00002, 0.0, 0.0, 0.0, 1.0, 0.2, 0.1, 0.1)
    rows.append(_row(PUMA_260, tuple(as_float32(x) for x in crooked), 0))
    return table(_COLUMNS, rows)


def straight() -> str:
    """A straight wrist: θ4 is held, θ6 follows."""
    elements = sent(direct(PUMA_260, (0.4, 0.7, -1.9, 0.8, 0.0, 0.3)))
    arm, rows = geometry(PUMA_260), []
    for held in (0.0, 0.8, -2.0):
        angles = solve(arm, received(elements), CONFIGURATIONS[2], held)
        rows.append((number(held), *_angles(angles[3:])))
    return _said(elements) + table(("held θ4", "θ4", "θ5", "θ6"), rows)


def turns() -> str:
    """The turn that is taken, by the previous angle and the range."""
    from rfms_can.kinematics.limits import nearest_turn  # noqa: PLC0415 (the one user here)

    cases = (
        (3.0, 3.2, -6.0, 6.0),
        (-3.1, 3.1, -6.0, 6.0),
        (-3.1, 3.1, -6.0, 3.0),
        (0.5, 12.9, -4.0, 4.0),
        (-3.0, 0.0, -2.9, 3.5),
        (3.0, 0.0, -2.9, 2.9),
        (1.0, math.nan, -3.0, 3.0),
    )
    rows = []
    for angle, previous, lower, upper in cases:
        taken = nearest_turn(angle, previous, lower, upper)
        told = (number(x).replace("nan", "NaN") for x in (angle, previous, lower, upper))
        rows.append((*told, *_angles((taken,))))
    return table(("solution", "previous", "lower", "upper", "angle taken"), rows)


def geometries() -> str:
    """a2, a3, d4 and d of the arms, as CONFIG carries them."""
    rows = []
    for arm in ARMS:
        known = geometry(arm)
        lengths = (known.a2, known.a3, known.d4, known.shoulder_offset)
        rows.append((arm.name, *(number(x) for x in lengths)))
    return table(("arm", "a2, m", "a3, m", "d4, m", "d, m"), rows)


def told() -> str:
    """Joints 4, 5 and 6, pose after pose: theta4 is held as told, or as a pose gives it."""
    straight_pose = sent(direct(PUMA_260, (0.4, 0.7, -1.9, 0.8, 0.0, 0.3)))
    bent_pose = sent(direct(PUMA_260, (0.4, 0.7, -1.9, 0.5, 0.4, 0.3)))
    values = all_parameters(PUMA_260, "corke", PERIOD_S)
    solvers = {joint: AngleSolver(values[joint], joint) for joint in (4, 5, 6)}
    rows = []
    for word, pose, theta4 in (
        ("straight", straight_pose, None),
        ("straight", straight_pose, 0.8),
        ("straight", straight_pose, None),
        ("bent", bent_pose, None),
        ("straight", straight_pose, None),
        ("bent", bent_pose, -2.0),
        ("straight", straight_pose, None),
    ):
        angles = tuple(_told_angle(solvers[joint], pose, theta4) for joint in (4, 5, 6))
        rows.append((word, "" if theta4 is None else number(theta4), *_angles(angles)))
    head = "".join(_said(pose).replace("```\n\n", "```\n") for pose in (straight_pose, bent_pose))
    return head + "\n" + table(("pose", "joint_4 told", "θ4", "θ5", "θ6"), rows)


def _told_angle(solver: AngleSolver, elements: tuple[float, ...], theta4: float | None) -> float:
    """A joint's angle of a pose of SETPOINT_1; with ``theta4`` bit 3 of JOINT_SETPOINT_1 is set."""
    pose, code = received(elements), CONFIGURATIONS[2]
    if theta4 is None:
        return solver.solve(pose, code, 0.0)
    setpoint = CartesianSetpoint(
        *(TrajectoryState.IDLE, Mode.JOINT, Blend.CONTINUOUS, 0.0, 0.0, 0.2),
        *(pose, code, None, code),
    )
    angles = JointAngles(0.0, 0.0, 0.0, as_float32(theta4), 0.0, 0.0, 0, 8)
    return solver.given(setpoint, angles, None)(pose, code, 0.0)
