"""The arm and its scene as a MuJoCo model."""

from collections.abc import Sequence
from math import cos, sin
from typing import Final

import mujoco
import numpy as np

from rfms_can.arm import Arm, JointFriction
from rfms_can.errors import PlantError
from rfms_can.plant.scene import EDGE_RADIUS, Contact, Kind, Scene, Shape, Tool
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
IMPEDANCE: Final = 0.5
"""MuJoCo's d: the fraction of a contact's acceleration that its constraint prescribes. With less,
spring and damper need shorter steps; near 1, MuJoCo's contact is rigid and ignores the spring."""
SLIDING_RATE: Final = 10.0
"""Rate at which friction reduces a sliding speed, 1/s, while the load is inside the friction cone.

MuJoCo's cone is convex: a body sliding at speed v is lifted as if its contact were softer, here by
friction SLIDING_RATE v / s0. With MuJoCo's default, the damping of the normal spring, a ball
pressed on with 20 N leaves the plate at 40 mm/s, and chatters."""
FRICTION_IMPEDANCE_RATIO: Final = 1e4
"""MuJoCo's impratio. A contact that sticks creeps there, by (1 - d) w / (impratio SLIDING_RATE):
0.7 micrometres a second under each newton."""
DISTANCE_TOLERANCE: Final = 1e-9
"""Of MuJoCo's distance of two shapes, m. The default of a micrometre corresponds to 10 N."""
SKIN: Final = EDGE_RADIUS
"""By how much MuJoCo's shapes are smaller than the solid ones, m.

Where two shapes overlap by less than its tolerance, MuJoCo 4 returns a wrong contact normal: with
the default tolerance for one in a hundred contacts of a leaning peg with a chamfer, by up to 117
degrees, and a peg wedged between two such faces meets large forces without a cause. For separate
shapes, distance and normal are exact, so a skin on each keeps them separate."""
CONTACT_DISTANCE: Final = 2.0 * SKIN
"""Distance of MuJoCo's shapes at which the solid surfaces touch, m."""


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
    _add_fixtures(spec, scene)
    if scene.tool is not None:
        _add_tool(spec, body.add_body(name=TOOL, pos=position, quat=quaternion), scene.tool, scene)
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


def _add_fixtures(spec: mujoco.MjSpec, scene: Scene) -> None:
    """Put the scene's fixtures around the arm."""
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = FRICTION_IMPEDANCE_RATIO
    spec.option.ccd_tolerance = DISTANCE_TOLERANCE
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
            _add_contact_pair(spec, name, fixture, scene.contact)


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


def _add_contact_pair(spec: mujoco.MjSpec, tool: str, fixture: str, contact: Contact) -> None:
    """Add an explicit contact pair: only there does MuJoCo let friction have its own solref."""
    spec.add_pair(
        geomname1=fixture,
        geomname2=tool,
        condim=3,
        margin=CONTACT_DISTANCE,
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
