"""Who stops the arm when part of the bus dies in mid-motion: every node by itself."""

import math
from collections.abc import Sequence

import pytest

from rfms_can.bus.controller import Controller
from rfms_can.bus.simulated import SimulatedBus
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.kinematics import direct
from rfms_can.master.phases import Phase
from rfms_can.messages import ModeMessage, MoveRequest, PositionMessage, TransformMessage
from rfms_can.plant.brake_watchdog import SPEECHLESS_CYCLES
from rfms_can.rig.nodes import make_gripper, make_joint, make_master, make_plant
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Dac, Estop, Measure
from rfms_can.wire.vocabulary import FaultCode, NodeState

pytestmark = pytest.mark.system

SECOND = 1_000_000_000
AWAY = (0.6, 0.3, -0.5, 0.5, 0.4, -0.6)
"""Where the arm is sent from park, rad: all joints at once, and not slowly."""

HARDEST = 4.0
"""Largest acceleration over its limit of a joint that comes to rest on its ramp, shaken by the one
beside it that its brake stops at once; on their own brakes they had 8 to 20."""


class Rig:
    """All nine nodes on the simulated bus, with a plug for each."""

    def __init__(self, wire: Wire, arm: str) -> None:
        settings = RunSettings(arm=arm)
        self.arm = settings.the_arm
        self.bus = SimulatedBus()
        self.joints = [make_joint(joint, settings, wire) for joint in JOINTS]
        self.gripper = make_gripper(settings, wire)
        self.plant = make_plant(settings, wire)
        self.master = make_master(settings, wire)
        nodes = (*self.joints, self.gripper, self.plant, self.master)
        self.plugs: dict[str, Controller] = {node.name: self.bus.attach(node) for node in nodes}
        self.fastest = [0.0] * len(JOINTS)
        self.lowest = [math.inf] * len(JOINTS)
        self.highest = [-math.inf] * len(JOINTS)
        self.braked = [False] * len(JOINTS)
        self.path: list[list[float]] = []
        self.brakes: list[list[bool]] = []
        self.plant._observe = self._keep_cycle
        self._measures = {wire.id(Measure, joint): wire.codec(Measure, joint) for joint in JOINTS}
        self.bus.observers.append(self._watch_brakes)

    def _watch_brakes(self, _: int, frame: Frame, sender: str) -> None:
        if frame.id in self._measures and sender == "plant":
            measure = self._measures[frame.id].unpack(frame.data)
            assert measure is not None
            self.braked[(frame.id & 0xF) - 1] = bool(measure.braked)

    def _keep_cycle(self, _: int) -> None:
        """True angles at the begin of a cycle, and the brakes of the one to come."""
        self.path.append(list(self.plant.physics.true_q))
        self.brakes.append([self.plant._brakes.closed(joint - 1) for joint in JOINTS])

    def hardest(self, *but: int) -> float:
        """Largest acceleration over its limit since ``path`` was cleared, of joints but some."""
        period_s = self.master.settings.period_ns * 1e-9
        limits = self.arm.acceleration_limits
        return max(
            abs(q2[i] - 2.0 * q1[i] + q0[i]) / period_s**2 / limits[i]
            for q0, q1, q2 in zip(self.path, self.path[1:], self.path[2:], strict=False)
            for i in range(len(JOINTS))
            if i + 1 not in but
        )

    def enable(self) -> "Rig":
        self.bus.run_until(lambda: self.master.phase is Phase.READY)
        self.master.start()
        self.bus.run_until(lambda: self.master.phase is Phase.RUN)
        self.run(0.2)
        return self

    def move_away(self) -> None:
        """Start a motion of 0.8 s and let it come to full speed."""
        goal = [q + way for q, way in zip(self.arm.park, AWAY, strict=True)]
        self.master.handle(TransformMessage("goal", direct(self.arm, goal)))
        self.master.handle(PositionMessage("away", ["t6"], ["goal"]))
        self.master.handle(ModeMessage("swift", "joint", 0.2, 0.8))
        self.master.handle(MoveRequest("away", "swift"))
        self.run(0.4)
        assert max(map(abs, self.plant.physics.true_qd)) > 0.5

    def run(self, seconds: float) -> None:
        """Let time pass, and watch the true arm."""
        until_ns = self.bus.now_ns + round(seconds * SECOND)
        while self.bus.now_ns < until_ns:
            self.bus.run_until(self.bus.now_ns + 1_000_000)
            physics = self.plant.physics
            for i, (q, qd) in enumerate(zip(physics.true_q, physics.true_qd, strict=True)):
                self.fastest[i] = max(self.fastest[i], abs(qd))
                self.lowest[i] = min(self.lowest[i], q)
                self.highest[i] = max(self.highest[i], q)

    def assert_within_limits(self) -> None:
        """Speeds and ranges of every joint, ever since."""
        for i in range(len(JOINTS)):
            lower, upper = self.arm.joint_limits[i]
            assert self.fastest[i] <= self.arm.speed_limits[i], f"joint {i + 1}"
            assert lower <= self.lowest[i] <= self.highest[i] <= upper, f"joint {i + 1}"

    def assert_at_rest(self) -> None:
        """No joint moves by more than two encoder counts in half a second."""
        before = list(self.plant.physics.true_q)
        self.run(0.5)
        after = self.plant.physics.true_q
        for q0, q, drive in zip(before, after, self.arm.drives, strict=True):
            assert abs((q - q0) * drive.counts_per_radian) < 2.0


@pytest.fixture(params=["puma260", "puma560"])
def rig(request: pytest.FixtureRequest, wire: Wire) -> Rig:
    return Rig(wire, request.param).enable()


def test_the_arm_comes_to_rest_when_the_master_dies_in_mid_motion(rig: Rig) -> None:
    rig.move_away()
    rig.bus.detach(rig.plugs["master"])
    rig.run(0.05)
    assert {node.state for node in rig.joints} <= {NodeState.QUICKSTOP, NodeState.FAULT}
    rig.run(1.0)
    rig.assert_at_rest()
    rig.assert_within_limits()
    assert rig.braked == [True] * len(JOINTS)
    assert {node.reaction for node in rig.joints} == {Reaction.OFF}
    assert {node.state for node in rig.joints} == {NodeState.FAULT}
    for node in rig.joints:
        assert list(node.faults) == [FaultCode.SYNC_MISSING]


def test_the_arm_holds_its_place_under_gravity_with_brakes_alone(rig: Rig) -> None:
    rig.bus.detach(rig.plugs["master"])
    before = list(rig.plant.physics.true_q)
    rig.run(2.0)
    fallen = [abs(q - b) for q, b in zip(rig.plant.physics.true_q, before, strict=True)]
    assert max(fallen) < 2e-3
    rig.assert_at_rest()


@pytest.mark.parametrize("joint", [1, 2, 5])
def test_the_others_stop_when_one_joint_node_dies(rig: Rig, joint: int) -> None:
    rig.move_away()
    rig.bus.detach(rig.plugs[f"joint {joint}"])
    rig.run(1.0)
    rig.assert_at_rest()
    rig.assert_within_limits()
    assert rig.braked == [number == joint for number in JOINTS]
    assert rig.master.phase is Phase.HALT
    assert rig.master.fault is not None
    running_names = [node for node in rig.joints if node.number != joint]
    assert {node.state for node in running_names} == {NodeState.QUICKSTOP}


def test_torque_ends_everywhere_when_the_plant_falls_silent(rig: Rig) -> None:
    rig.move_away()
    rig.bus.detach(rig.plugs["plant"])
    rig.bus.run_until(rig.bus.now_ns + SECOND // 10)
    assert {node.state for node in rig.joints} == {NodeState.FAULT}
    assert {node.reaction for node in rig.joints} == {Reaction.OFF}
    assert rig.master.fault is not None


def test_an_emergency_stop_from_anybody_brakes_the_arm(rig: Rig, wire: Wire) -> None:
    rig.move_away()
    stop: Frame = wire.sender(Estop).frame(*ESTOP_VALUES)
    rig.bus.send(rig.plugs["gripper"], (stop,))
    rig.run(0.1)
    rig.assert_at_rest()
    rig.assert_within_limits()
    assert rig.master.fault is not None
    assert {node.state for node in rig.joints} == {NodeState.FAULT}
    assert all(rig.braked)


# --- brakes close on what must be held, and on nothing else -----------------------------------


@pytest.mark.parametrize("joint", JOINTS)
def test_the_brake_of_a_silent_joint_alone_closes(rig: Rig, joint: int) -> None:
    """All six closed for a cycle, and let go again."""
    rig.move_away()
    del rig.path[:-2], rig.brakes[:]
    rig.bus.detach(rig.plugs[f"joint {joint}"])
    rig.run(1.0)
    closed = [brakes.index(True) + 1 for brakes in rig.brakes if any(brakes)]
    assert set(closed) == {joint}
    assert max(map(sum, rig.brakes)) == 1
    first = next(cycle for cycle, brakes in enumerate(rig.brakes) if any(brakes))
    assert first <= SPEECHLESS_CYCLES + 1
    assert rig.hardest(joint) < HARDEST
    rig.assert_at_rest()


def test_frames_lost_in_a_burst_close_no_brake(rig: Rig, wire: Wire) -> None:
    """For three cycles the plant hears none of the joints: it holds what it has."""
    rig.move_away()
    del rig.path[:-2], rig.brakes[:]
    dacs = {wire.id(Dac, joint) for joint in JOINTS}
    hears, until = rig.plant.on_frame, rig.bus.now_ns + 3 * rig.master.settings.period_ns

    def deaf(frame: Frame, now_ns: int) -> Sequence[Frame]:
        return () if frame.id in dacs and now_ns < until else hears(frame, now_ns)

    rig.plant.on_frame = deaf  # type: ignore[method-assign]
    rig.run(1.0)
    assert not any(map(any, rig.brakes))
    assert rig.hardest() < HARDEST


def test_a_hung_joint_that_wakes_stays_on_its_brake_until_reset(rig: Rig) -> None:
    rig.move_away()
    hung = rig.joints[1]
    rig.bus.detach(rig.plugs["joint 2"])
    rig.run(0.5)
    rig.bus.attach(hung)
    del rig.brakes[:]
    rig.run(0.5)
    assert set(map(tuple, rig.brakes)) == {tuple(number == 2 for number in JOINTS)}
    assert rig.plant.ignored["DAC of a node that was lost"] > 0
    assert rig.plant._codes[1] == rig.plant._force_codes[1] == 0
    rig.master.reset()
    rig.bus.run_until(lambda: rig.master.phase is Phase.RUN or rig.master.fault is not None)
    assert rig.master.fault is None
    rig.run(0.2)
    assert rig.braked == [False] * len(JOINTS)


@pytest.mark.parametrize("ready_cycles", range(7))
def test_an_arm_enabled_at_any_time_after_homing_opens_all_brakes(
    wire: Wire, ready_cycles: int
) -> None:
    """Joints are silent while READY, and none is lost by it."""
    rig = Rig(wire, "puma260")
    rig.bus.run_until(lambda: rig.master.phase is Phase.READY)
    rig.run(ready_cycles * rig.master.settings.period_ns / SECOND)
    rig.master.start()
    rig.bus.run_until(lambda: rig.master.phase is Phase.RUN)
    rig.run(0.2)
    assert rig.braked == [False] * len(JOINTS)
    rig.master.stop()
    rig.bus.run_until(lambda: rig.master.ended)
    assert rig.braked == [True] * len(JOINTS)
    assert not any(rig.plant._brakes.lost(joint - 1) for joint in JOINTS)
