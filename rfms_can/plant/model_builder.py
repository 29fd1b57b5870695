"""The arm and its scene as a MuJoCo model."""

from collections.abc import Sequence
from math import cos, sin
from typing import Final

import mujoco
import numpy as np

from rfms_can.arm import Arm, JointFriction
from rfms_can.errors import PlantError
from rfms_can.plant.contact import SKIN, add_contact_pair, set_options, set_stiffness
from rfms_can.plant.scene import Kind, Scene, Shape, Tool
from rfms_can.tables import complete
from rfms_can.transform import Transform, Vector3

GRAVITY: Final = 9.81  # m/s2, along -z of the base
WRIST_FORCE, WRIST_TORQUE = "wrist force", "wrist torque"
"""Sensors between hand and tool, at T6; the model has no others, and these in this order."""
TOOL, TIP = "tool", "tip"
"""Body of the tool, and site of its tip."""

_GEOMETRY: Final = complete(
    {
        Kind.BOX: mujoco.mjtGeom.mjGEOM_BOX,
        Kind.CYLINDER: mujoco.mjtGeom.mjGEOM_CYLINDER,
        Kind.SPHERE: mujoco.mjtGeom.mjGEOM_SPHERE,
        Kind.PLANE: mujoco.mjtGeom.mjGEOM_PLANE,
    },
    Kind,
)


def compile_model(
    arm: Arm, friction: Sequence[JointFriction], physics_step_s: float, scene: Scene
) -> mujoco.MjModel:
    """The model: joint i turns about z of frame i - 1, base on the joint-2 axis.

    Raises:
        PlantError: MuJoCo refuses it, with its text.
    """
    spec = mujoco.MjSpec()
    spec.modelname = arm.name
    spec.option.timestep = physics_step_s
    spec.option.gravity = [0.0, 0.0, -GRAVITY]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER  # damping implicit, all else not
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_AUTORESET  # the culprit state stays
    body, position, quaternion = spec.worldbody, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    for index, (alpha, a, d) in enumerate(arm.dh):
        link = arm.links[index]
        body = body.add_body(name=f"link{index + 1}", pos=position, quat=quaternion)
        lower, upper = arm.hard_stops[index]
        body.add_joint(
            name=f"joint{index + 1}",
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=[0.0, 0.0, 1.0],
            range=[lower, upper],
            limited=mujoco.mjtLimited.mjLIMITED_FALSE,  # DryFriction has the stops
            armature=arm.drives[index].armature,
            damping=friction[index].viscous,
        )
        # A_i = Rz(q) times this fixed part: the link's own frame, seen from its joint.
        c, s = cos(alpha), sin(alpha)
        x, y, z = link.com
        position, quaternion = [a, 0.0, d], [cos(alpha / 2.0), sin(alpha / 2.0), 0.0, 0.0]
        body.explicitinertial = True
        body.mass = link.physical_mass
        body.ipos = [a + x, c * y - s * z, d + s * y + c * z]
        body.iquat = quaternion
        body.inertia = link.physical_inertia
    body.add_site(name="t6", pos=position, quat=quaternion)
    _add_fixtures(spec, scene)
    if scene.tool is not None:
        _add_tool(spec, body.add_body(name=TOOL, pos=position, quat=quaternion), scene.tool, scene)
    try:
        model = spec.compile()
    except ValueError as error:
        raise PlantError(f"MuJoCo refuses the model of {arm.name}: {error}") from error
    if scene.tool is not None:
        set_stiffness(model, scene.contact, TOOL)
    return model


def _add_fixtures(spec: mujoco.MjSpec, scene: Scene) -> None:
    """Put the scene's fixtures around the arm."""
    set_options(spec)
    for shape in scene.fixtures:
        _add_shape(spec.worldbody, shape)


def _add_tool(spec: mujoco.MjSpec, body: mujoco.MjsBody, tool: Tool, scene: Scene) -> None:
    """Attach the tool to the hand with the wrist sensors; add its contacts with the fixtures."""
    body.explicitinertial = True
    body.mass, body.ipos, body.inertia = tool.mass, list(tool.com), list(tool.inertia)
    body.add_site(name="wrist")
    tip = tool.tip
    body.add_site(name=TIP, pos=[tip.px, tip.py, tip.pz], quat=_quaternion(tip))
    for name, kind in (
        (WRIST_FORCE, mujoco.mjtSensor.mjSENS_FORCE),
        (WRIST_TORQUE, mujoco.mjtSensor.mjSENS_TORQUE),
    ):
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="wrist")
    fixtures = [geom.name for geom in spec.worldbody.geoms]
    for shape in tool.shapes:
        name = _add_shape(body, shape)
        for fixture in fixtures if shape.solid else ():
            add_contact_pair(spec, name, fixture, scene.contact)


def _add_shape(body: mujoco.MjsBody, shape: Shape) -> str:
    """Add a geometry without contacts, shrunk by the skin if it is solid; its name."""
    size, pose = _core(shape) if shape.solid else (shape.size, shape.pose)
    name = f"{body.name} {len(body.geoms)}"
    body.add_geom(
        name=name,
        type=_GEOMETRY[shape.kind],
        size=list(size),
        pos=[pose.px, pose.py, pose.pz],
        quat=_quaternion(pose),
        contype=0,
        conaffinity=0,
    )
    return name


def _core(shape: Shape) -> tuple[Vector3, Transform]:
    """Size and pose of a shape shrunk by the skin; a plane is lowered by it."""
    if shape.kind is Kind.PLANE:
        return shape.size, shape.pose @ Transform.translation(0.0, 0.0, -SKIN)
    x, y, z = (max(extent - SKIN, 0.0) for extent in shape.size)
    return (x, y, z), shape.pose


def _quaternion(pose: Transform) -> list[float]:
    """The rotation of a pose, w first."""
    rotation = [*(pose.nx, pose.ox, pose.ax), *(pose.ny, pose.oy, pose.ay)]
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.array([*rotation, pose.nz, pose.oz, pose.az]))
    values: list[float] = quaternion.tolist()
    return values
