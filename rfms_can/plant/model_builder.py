"""The arm and its scene as a MuJoCo model."""

from collections.abc import Sequence
from math import cos, sin
from typing import Final

import mujoco
import numpy as np

from rfms_can.arm import Arm, JointFriction
from rfms_can.errors import PlantError
from rfms_can.plant.scene import ROUNDING, Contact, Kind, Scene, Shape, Tool
from rfms_can.tables import complete
from rfms_can.transform import Transform, Vector3

GRAVITY: Final = 9.81  # m/s2, along -z of the base
WRIST_FORCE, WRIST_TORQUE = "wrist force", "wrist torque"
"""Sensors between hand and tool, at T6; the model has no others, and these in this order."""
TOOL, TIP = "tool", "tip"
"""What the hand holds, and the site of its tip."""

_GEOMETRY: Final = complete(
    {
        Kind.BOX: mujoco.mjtGeom.mjGEOM_BOX,
        Kind.CYLINDER: mujoco.mjtGeom.mjGEOM_CYLINDER,
        Kind.SPHERE: mujoco.mjtGeom.mjGEOM_SPHERE,
        Kind.PLANE: mujoco.mjtGeom.mjGEOM_PLANE,
    },
    Kind,
)
IMPEDANCE: Final = 0.5
"""MuJoCo's d: the part of a contact's acceleration that its constraint prescribes. Less of it, and
spring and damper need shorter steps; near 1, the spring is lost in what MuJoCo makes rigid."""
SLIDING_RATE: Final = 10.0
"""Rate at which friction takes away what slides, 1/s, while the load is under its cone.

MuJoCo's cone is convex: what slides at speed v is lifted as if its contact were softer, here by
friction SLIDING_RATE v / s0. With the damping of the normal spring in this place, as MuJoCo has it
if nothing is said, a ball pressed on with 20 N leaves the plate at 40 mm/s, and chatters."""
FRICTION_IMPEDANCE_RATIO: Final = 1e4
"""MuJoCo's impratio. A contact that sticks creeps there, by (1 - d) w / (impratio SLIDING_RATE):
0.7 micrometres a second under each newton."""
DISTANCE_TOLERANCE: Final = 1e-9
"""Of MuJoCo's distance of two shapes, m. Its usual one, a micrometre, is 10 N."""
SKIN: Final = ROUNDING
"""How far under the surface of a solid shape MuJoCo's own lies, m.

Where two shapes overlap by less than its tolerance, MuJoCo 4 makes up the direction in which they
touch: with the usual one, one in a hundred of a leaning peg's contacts with a chamfer, by up to 117
degrees; and a peg wedged between two such faces pushes hard against nothing. Apart, distance and
direction are exact. So they are kept apart: by a skin on each."""
TOUCHING: Final = 2.0 * SKIN
"""Distance at which contact begins between MuJoCo's shapes, m: that of the surfaces is then 0."""


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
        lower, upper = arm.joint_limits[index]
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
    _furnish(spec, scene)
    if scene.tool is not None:
        _hold(spec, body.add_body(name=TOOL, pos=position, quat=quaternion), scene.tool, scene)
    try:
        model = spec.compile()
    except ValueError as error:
        raise PlantError(f"MuJoCo refuses the model of {arm.name}: {error}") from error
    if scene.tool is not None:
        _stiffen(model, scene.contact)
    return model


def _stiffen(model: mujoco.MjModel, contact: Contact) -> None:
    """Give every contact its stiffness and damping.

    MuJoCo's contact has a spring and a damper per unit of mass: with parameters s0 and s1 its force
    at rest is s0 depth / ((1 - d) w), where w is the tool's mean inverse mass at the angles 0.
    Solved for s0, the stiffness is that asked for, in N/m, wherever the arm stands.
    """
    inverse_mass = float(model.body(TOOL).invweight0[0])  # of a translation, 1/kg
    spring = contact.stiffness * (1.0 - IMPEDANCE) * inverse_mass
    model.pair_solref[:] = -spring, -2.0 * contact.damping * spring**0.5


def _furnish(spec: mujoco.MjSpec, scene: Scene) -> None:
    """Put the scene's fixtures around the arm."""
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = FRICTION_IMPEDANCE_RATIO
    spec.option.ccd_tolerance = DISTANCE_TOLERANCE
    for shape in scene.fixtures:
        _add_shape(spec.worldbody, shape)


def _hold(spec: mujoco.MjSpec, body: mujoco.MjsBody, tool: Tool, scene: Scene) -> None:
    """Put the tool into the hand, and the sensors between the two; let it meet the fixtures."""
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
            _let_meet(spec, name, fixture, scene.contact)


def _add_shape(body: mujoco.MjsBody, shape: Shape) -> str:
    """A geometry that meets nothing yet, under its skin if it is solid; its name."""
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
    """Size and pose of what is under a shape's skin. A plane has no edges: it lies lower."""
    if shape.kind is Kind.PLANE:
        return shape.size, shape.pose @ Transform.translation(0.0, 0.0, -SKIN)
    x, y, z = (max(extent - SKIN, 0.0) for extent in shape.size)
    return (x, y, z), shape.pose


def _let_meet(spec: mujoco.MjSpec, tool: str, fixture: str, contact: Contact) -> None:
    """A pair, because only a pair's friction has a reference of its own."""
    spec.add_pair(
        geomname1=fixture,
        geomname2=tool,
        condim=3,
        margin=TOUCHING,
        friction=[contact.friction, contact.friction, 0.0, 0.0, 0.0],
        solimp=[IMPEDANCE, IMPEDANCE, 1e-3, 0.5, 2.0],
        solreffriction=[-1.0, -SLIDING_RATE],
    )


def _quaternion(pose: Transform) -> list[float]:
    """The rotation of a pose, w first."""
    rotation = [*(pose.nx, pose.ox, pose.ax), *(pose.ny, pose.oy, pose.ay)]
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.array([*rotation, pose.nz, pose.oz, pose.az]))
    values: list[float] = quaternion.tolist()
    return values
