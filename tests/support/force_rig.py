"""A fleet that a hand pushes, and that complies."""

from typing import Any

import numpy as np

from rfms_can.kinematics import direct, jacobian
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
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from support.nodes_rig import Fleet

NO_WAY = (0.0,) * 6


class PushedFleet(Fleet):
    """All nine nodes, and a hand at the tool.

    Attributes:
        push: what the hand does to the arm, a wrench at T6 along its axes, N and N m (6).
    """

    def __init__(self, wire: Wire, **settings: Any) -> None:
        super().__init__(wire, **settings)
        self.push: tuple[float, ...] = NO_WAY
        self._asked = 0
        model = self.plant.physics.model
        steps = model.step

        def pushed(torque: Any, *more: Any) -> None:
            if any(self.push):
                by = np.array(jacobian(self.master.arm, list(model.q))).T @ self.push
                torque = [t + x for t, x in zip(torque, by.tolist(), strict=True)]
            steps(torque, *more)

        model.step = pushed  # type: ignore[method-assign,assignment]  # nobody on the bus knows of it

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

    def move(
        self,
        way: tuple[float, ...] = NO_WAY,
        seconds: float = 0.4,
        frame: Transform | None = None,
        **mode: Any,
    ) -> int:
        """Move from park by joint angles, rad; ``frame`` in T6 complies. Its sequence number."""
        master = self.master
        self._asked += 1
        n = self._asked
        goal = direct(master.arm, [q + step for q, step in zip(master.arm.park, way, strict=True)])
        tool = Transform.identity() if frame is None else frame
        master.handle(TransformMessage(f"goal {n}", goal @ tool))
        master.handle(TransformMessage(f"tool {n}", tool))
        master.handle(PositionMessage(f"there {n}", ["t6", f"tool {n}"], [f"goal {n}"]))
        master.handle(ModeMessage(f"mode {n}", "joint", 0.1, seconds, **mode))
        return master.handle(MoveRequest(f"there {n}", f"mode {n}")).sequence

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
