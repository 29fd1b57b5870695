"""A program's motion without a bus: definitions and moves of an arm at park, and its set-points."""

from collections.abc import Sequence
from typing import Any

from rfms_can.arm import PUMA_260, Arm
from rfms_can.master.motion import Motion
from rfms_can.messages import (
    Answer,
    JointPositionMessage,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    RemoveRequest,
    TransformMessage,
)
from rfms_can.setpoint import CartesianSetpoint
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend

PERIOD_S = 0.004


class Program:
    """An arm, and a program of it: one set-point a cycle.

    Args:
        arm: the arm.
        start: joint angles it is at, rad; at park if None.

    Attributes:
        motion: of the master.
        park: where the arm is at first.
        setpoints: all that were made.
    """

    def __init__(
        self, arm: Arm = PUMA_260, start: Sequence[float] | None = None, **settings: Any
    ) -> None:
        self.motion = Motion(arm, PERIOD_S, Blend.CONTINUOUS, lambda *_: None, **settings)
        self.motion.enable(arm.park if start is None else start)
        self.park = self.motion.generator.tick().T6_1
        self.setpoints: list[CartesianSetpoint] = []

    def transform(self, name: str, x: float, y: float = 0.0, z: float = 0.0) -> Answer:
        """A value: a translation from where the arm is at first."""
        value = self.park @ Transform.translation(x, y, z)
        return self.motion.handle(TransformMessage(name, value))

    def position(self, name: str, *right: str) -> Answer:
        """A position by the transforms right of ``t6 ==``."""
        return self.motion.handle(PositionMessage(name, ["t6"], list(right)))

    def joint_position(self, name: str, angles: Sequence[float]) -> Answer:
        """A position by its joint angles, rad."""
        q1, q2, q3, q4, q5, q6 = angles
        return self.motion.handle(JointPositionMessage(name, (q1, q2, q3, q4, q5, q6)))

    def place(self, name: str, x: float, y: float = 0.0, z: float = 0.0) -> None:
        """A transform, and the position of that name."""
        self.transform(name, x, y, z)
        self.position(name, name)

    def mode(self, name: str, seconds: float = 0.4, **more: Any) -> Answer:
        """A mode, in straight lines unless it says otherwise."""
        settings = {"interpolation": "cartesian", "acceleration_time": 0.1, **more}
        return self.motion.handle(ModeMessage(name, segment_time=seconds, **settings))

    def move(self, position: str, mode: str) -> Answer:
        """Ask for a move."""
        return self.motion.handle(MoveRequest(position, mode))

    def remove(self, name: str, what: Any = None) -> None:
        """Remove a name."""
        self.motion.handle(RemoveRequest(name, what))

    def run(self, cycles: int) -> Transform:
        """Make set-points; the last pose."""
        for _ in range(cycles):
            setpoint = self.motion.next_setpoint()
            assert self.motion.stopped_short is None
            self.setpoints.append(setpoint)
        return self.setpoints[-1].T6_1

    def finish(self) -> Transform:
        """Make set-points until the arm rests; the last pose."""
        while not self.motion.at_rest:
            self.run(1)
        return self.run(4)
