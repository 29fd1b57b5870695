"""Nodes pumped with plain function calls: no bus model, no sleeping.

``Pump`` carries frames between any nodes, at once and in order, unless told to lose, repeat or
delay some. ``Fleet`` is all nine nodes on a pump, ``PushedFleet`` one whose tool a hand pushes.
"""

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from rfms_can.joint_nodes.gripper import GripperNode
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.kinematics import direct, jacobian
from rfms_can.master.node import MasterNode
from rfms_can.master.phases import Phase
from rfms_can.master.report import holds
from rfms_can.messages import (
    ComplyRequest,
    LockRequest,
    ModeMessage,
    MoveOver,
    MoveRequest,
    PositionMessage,
    TransformMessage,
)
from rfms_can.node.protocol import Node, hears_itself
from rfms_can.plant.node import PlantNode
from rfms_can.plant.physics import PlantPhysics
from rfms_can.plant.wrist_sensor import sensor_from
from rfms_can.rig.settings import RunSettings
from rfms_can.transform import Transform
from rfms_can.wire.configuration import Clock
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, JOINTS
from support.bench import Reader

Fate = Callable[[Frame, Node], bool]
ZERO6 = (0.0,) * 6


class Pump:
    """Carries frames between nodes and keeps their time.

    Attributes:
        now_ns: time; moves on from deadline to deadline.
        sent: every frame handed over, in order.
    """

    def __init__(self, *nodes: Node) -> None:
        self.nodes = list(nodes)
        self.now_ns = 0
        self.sent: list[Frame] = []
        self._fates: list[tuple[Fate, int, int]] = []  # whom, copies, delay
        self._accepts: dict[str, frozenset[int]] = {}
        self._queue: deque[tuple[Node, Frame]] = deque()
        self._later: list[tuple[int, Node, Frame]] = []

    def lose(self, fate: Fate) -> None:
        """Frames, receiver by receiver, that do not arrive."""
        self._fates.append((fate, 0, 0))

    def repeat(self, fate: Fate) -> None:
        """Frames that arrive twice."""
        self._fates.append((fate, 2, 0))

    def delay(self, fate: Fate, delay_ns: int) -> None:
        """Frames that arrive late."""
        self._fates.append((fate, 1, delay_ns))

    def heal(self) -> None:
        """From now on every frame arrives once and at once."""
        self._fates.clear()

    def post(self, frames: Iterable[Frame], sender: Node | None = None) -> None:
        """Deliver frames as if another node had sent them; ``sender`` does not hear its own."""
        for frame in frames:
            self.sent.append(frame)
            for node in self.nodes:
                if node is sender and not hears_itself(node):
                    continue
                if frame.id not in self._accepted_by(node):
                    continue
                copies, delay_ns = next(
                    ((c, d) for fate, c, d in self._fates if fate(frame, node)), (1, 0)
                )
                if delay_ns:
                    self._later.append((self.now_ns + delay_ns, node, frame))
                else:
                    self._queue.extend([(node, frame)] * copies)

    def _accepted_by(self, node: Node) -> frozenset[int]:
        accepts = self._accepts.get(node.name)
        if accepts is None:
            accepts = self._accepts[node.name] = node.accepts
        return accepts

    def run_until(self, goal: Callable[[], bool], most: int = 1_000_000) -> None:
        """Go on until ``goal`` holds; it must within ``most`` events."""
        for _ in range(most):
            if goal():
                return
            self.step()
        raise AssertionError(f"not reached in {most} events")

    def step(self) -> None:
        """Deliver one frame, or, when all are silent, do what is due next."""
        if self._queue:
            node, frame = self._queue.popleft()
            self.post(node.on_frame(frame, self.now_ns), node)
            return
        times = [due_ns for due_ns, _, _ in self._later]
        times += [d for node in self.nodes if (d := node.next_deadline_ns()) is not None]
        assert times, "nothing is left to happen"
        self.now_ns = max(self.now_ns, min(times))
        arrived = [entry for entry in self._later if entry[0] <= self.now_ns]
        if arrived:
            self._later = [entry for entry in self._later if entry[0] > self.now_ns]
            self._queue.extend((node, frame) for _, node, frame in arrived)
            return
        for node in self.nodes:
            deadline_ns = node.next_deadline_ns()
            if deadline_ns is not None and deadline_ns <= self.now_ns:
                self.post(node.on_time(self.now_ns), node)
                return


def _physics(run: RunSettings) -> PlantPhysics:
    sensor = sensor_from(run.sensor, run.noise_seed)
    return PlantPhysics(run.the_arm, run.friction, run.rate, sensor=sensor)


class Fleet:
    """All nine nodes on a pump.

    Attributes:
        pump: carries their frames.
        master, joints, gripper, plant: the nodes.
    """

    def __init__(self, wire: Wire, clock: Clock = Clock.VIRTUAL, **settings: Any) -> None:
        run = RunSettings(patience=settings.pop("patience", 3.0), **settings)
        how = replace(run.master(), clock=clock)
        watch_ns = how.cycle_limit_ns
        arm = run.the_arm
        self.wire = wire
        self.joints = [JointNode(joint, wire, joint) for joint in JOINTS]
        self.gripper = GripperNode(wire, GRIPPER)
        self.plant = PlantNode(_physics(run), wire, 9, watch_ns)
        self.master = MasterNode(arm, wire, 8, how)
        self.pump = Pump(*self.joints, self.gripper, self.plant, self.master)
        self.reader = Reader(wire)
        self._moves = 0

    def reach(self, phase: Phase) -> "Fleet":
        """Run until the master has reached a phase."""
        self.pump.run_until(lambda: self.master.phase is phase)
        return self

    def enable(self) -> "Fleet":
        """From power-up to RUN, and through the first cycle."""
        self.reach(Phase.READY)
        self.master.start()
        self.reach(Phase.RUN)
        self.run(1)
        return self

    def run(self, cycles: int) -> None:
        """Close so many cycles more."""
        until = self.master.closed + cycles
        self.pump.run_until(lambda: self.master.closed >= until)

    def halted(self) -> str:
        """Run until the master gives up; its reason."""
        self.pump.run_until(lambda: self.master.fault is not None)
        assert self.master.phase is Phase.HALT
        assert self.master.fault is not None
        return self.master.fault

    def move(
        self,
        displacement: Sequence[float] = ZERO6,
        seconds: float = 0.4,
        frame: Transform | None = None,
        **mode: Any,
    ) -> int:
        """Move from park by joint angles, rad; ``frame`` in T6 complies. Its sequence number."""
        master = self.master
        self._moves += 1
        n = self._moves
        q = [park + step for park, step in zip(master.arm.park, displacement, strict=True)]
        goal = direct(master.arm, q)
        tool = Transform.identity() if frame is None else frame
        master.handle(TransformMessage(f"goal {n}", goal @ tool))
        master.handle(TransformMessage(f"tool {n}", tool))
        master.handle(PositionMessage(f"there {n}", ["t6", f"tool {n}"], [f"goal {n}"]))
        master.handle(ModeMessage(f"mode {n}", "joint", 0.1, seconds, **mode))
        return master.handle(MoveRequest(f"there {n}", f"mode {n}")).sequence

    def id(self, record: type[NamedTuple], node: int | None = None) -> int:
        """Identifier of a message."""
        return self.wire.id(record, node)

    def said(self, name: str, since: int = 0) -> list[Any]:
        """Values of every frame of a message, from ``since`` in ``pump.sent`` on."""
        identifier = self.wire.codecs[name].id
        frames = self.pump.sent[since:]
        return [self.reader.read(frame).values for frame in frames if frame.id == identifier]


class PushedFleet(Fleet):
    """All nine nodes, and a hand at the tool.

    Attributes:
        push: what the hand does to the arm, a wrench at T6 along its axes, N and N m (6).
    """

    def __init__(self, wire: Wire, **settings: Any) -> None:
        super().__init__(wire, **settings)
        self.push: tuple[float, ...] = ZERO6
        model = self.plant.physics.model
        steps = model.step

        def pushed(torque: Any, *more: Any) -> None:
            if any(self.push):
                by = np.array(jacobian(self.master.arm, list(model.q))).T @ self.push
                torque = [t + x for t, x in zip(torque, by.tolist(), strict=True)]
            steps(torque, *more)

        model.step = pushed  # type: ignore[method-assign,assignment]  # unseen on the bus

    @property
    def force(self) -> Any:
        """The master's force control."""
        return self.master.force_control

    def comply(self, word: str, *values: float) -> None:
        """From the next move on."""
        self.master.handle(ComplyRequest(word, list(values or (0.0,) * len(word.split()))))

    def lock(self, word: str) -> None:
        """From the next move on."""
        self.master.handle(LockRequest(word))

    def settle(self, sequence: int, most: int = 1000) -> None:
        """Run until a program that waits for a move would go on."""
        for _ in range(most):
            if holds(self.master, MoveOver(sequence)):
                return
            self.run(1)
        raise AssertionError(f"move {sequence} is not over after {most} cycles")

    def names(self, since: int) -> list[list[str]]:
        """Names of what was sent from ``since`` on, cut into cycles at the SYNCs."""
        cycles: list[list[str]] = []
        for frame in self.pump.sent[since:]:
            name = self.reader.read(frame).name
            if name == "SYNC":
                cycles.append([])
            if cycles:
                cycles[-1].append(name)
        return cycles
