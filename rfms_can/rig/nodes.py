"""Makes the nodes of a run from its settings."""

from collections.abc import Callable

from rfms_can.joint_nodes.gripper import GripperNode
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.master.node import MasterNode
from rfms_can.plant.node import PlantNode
from rfms_can.plant.physics import PlantPhysics
from rfms_can.plant.variant import make_variant
from rfms_can.plant.wrist_sensor import sensor_from
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import GRIPPER


def make_joint(joint: int, settings: RunSettings, wire: Wire) -> JointNode:
    """Joint node 1 to 6."""
    return JointNode(joint, wire, settings.boot_id(joint))


def make_gripper(settings: RunSettings, wire: Wire) -> GripperNode:
    """Node 7."""
    return GripperNode(wire, settings.boot_id(GRIPPER))


def make_master(settings: RunSettings, wire: Wire) -> MasterNode:
    """Node 8."""
    return MasterNode(settings.the_arm, wire, settings.boot_id(8), settings.master())


def make_physics(settings: RunSettings) -> PlantPhysics:
    """What node 9 integrates: boards, arm and gripper."""
    arm = settings.the_arm
    return PlantPhysics(
        arm,
        settings.friction,
        settings.rate,
        scene=settings.the_scene,
        sensor=sensor_from(settings.sensor, settings.noise_seed),
        variant=make_variant(settings.plant, arm, settings.friction),
    )


def make_plant(
    settings: RunSettings,
    wire: Wire,
    physics: PlantPhysics | None = None,
    observe: Callable[[int], None] | None = None,
) -> PlantNode:
    """Node 9; ``observe`` is called after each period, for those who look at its ``physics``."""
    if physics is None:
        physics = make_physics(settings)
    return PlantNode(physics, wire, settings.boot_id(9), settings.watch_ns, observe)
