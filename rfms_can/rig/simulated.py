"""All nine nodes on the simulated bus, in this process and in virtual time."""

from collections.abc import Callable

from rfms_can.bus.controller import Controller
from rfms_can.bus.simulated import SimulatedBus
from rfms_can.bus.timing import BusTiming
from rfms_can.joint_nodes.gripper import GripperNode
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.master.node import MasterNode
from rfms_can.plant.node import PlantNode
from rfms_can.rig.nodes import make_gripper, make_joint, make_master, make_physics, make_plant
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.torque_terms import TermsRecorder
from rfms_can.rig.truth import SceneResult, SceneWatch
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS


class SimulatedRig:
    """The embedded default: no kernel module, no process, no wall clock.

    Attributes:
        bus: the simulated bus.
        master, joints, gripper, plant: its nodes.
        controllers: of each node, by its number.
        watch: observer of the contact with the scene; None without one.
        terms: of the joints' torques, if they are recorded.
    """

    def __init__(self, settings: RunSettings, wire: Wire | None = None) -> None:
        wire = wire or Wire()
        self.bus = SimulatedBus(BusTiming(settings.bit_rate, settings.data_bit_rate))
        self.joints: list[JointNode] = [make_joint(joint, settings, wire) for joint in JOINTS]
        self.gripper: GripperNode = make_gripper(settings, wire)
        physics = make_physics(settings)
        self.watch: SceneWatch | None = None
        if settings.the_scene.tool is not None:
            self.watch = SceneWatch(physics, settings.scene)
        look = None if self.watch is None else self.watch.look
        self.plant: PlantNode = make_plant(settings, wire, physics, look)
        self.master: MasterNode = make_master(settings, wire)
        self.terms: TermsRecorder | None = None
        nodes = (*self.joints, self.gripper, self.plant, self.master)
        self.controllers: dict[int, Controller] = {
            node.number: self.bus.attach(node) for node in nodes
        }

    def observe(self, observer: Callable[[int, Frame], None]) -> None:
        """Show every frame to an observer, with its time in ns."""
        self.bus.observers.append(lambda time_ns, frame, _sender: observer(time_ns, frame))

    def record_terms(self) -> TermsRecorder:
        """Record what each joint's torque is made of, from ``begin_measuring`` on."""
        self.terms = TermsRecorder(self.joints)
        return self.terms

    def pump(self, condition: Callable[[], bool]) -> None:
        """Run until a condition holds."""
        self.bus.run_until(condition)

    def begin_measuring(self) -> None:
        """Start counting bus statistics and contacts."""
        self.bus.reset_statistics()
        if self.terms is not None:
            self.terms.begin()
        if self.watch is not None:
            self.watch.begin()

    @property
    def load(self) -> float | None:
        """Fraction of the time the bus was busy since ``begin_measuring``."""
        return self.bus.statistics.load(self.bus.now_ns)

    @property
    def frames(self) -> int:
        """Frames since ``begin_measuring``."""
        return sum(frame.count for frame in self.bus.statistics.frames.values())

    @property
    def scene(self) -> SceneResult | None:
        """Contact with the scene."""
        return None if self.watch is None else self.watch.result()

    def close(self) -> None:
        """Nothing to close."""
