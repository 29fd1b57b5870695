"""The trajectory generator and six joints without a bus, and how far two of their paths differ."""

import math
import struct
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.arm import PUMA_260
from rfms_can.kinematics import Configuration, Joints, JointSolver, direct
from rfms_can.master.trajectory.generator import TrajectoryGenerator
from rfms_can.master.trajectory.goal import FixedGoal, Goal, Moment
from rfms_can.master.trajectory.segment import Move, Transition, whole_ticks
from rfms_can.master.trajectory.states import Stage
from rfms_can.setpoint import CartesianSetpoint, JointSetpoint
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend, Mode
from support.golden import golden

LEFT_DOWN = Configuration.parse("left down noflip")
TAU = 0.005
HOME = (0.174532925199, 1.2217304764, -2.96705972839, 0.349065850399, 1.0471975512, -0.174532925199)
"""Where the golden trajectories start, rad."""
REST: Joints = (0.2, 1.2, -2.7, 0.3, 1.0, -0.2)
"""Joint angles that moves are planned from, and drawn near, rad."""


_STATIC: Any = golden("trajectory_static")
TOOL = Transform.from_rows(_STATIC["tool"])
POSITIONS = {name: Transform.from_rows(_STATIC[name]) for name in ("W0", "W1", "W2", "W3")}
"""Tool poses of the golden programs."""


class MovingGoal:
    """A target that moves at a constant velocity (m/s, base frame) from tick 0."""

    constant = False
    cycle_s = 0.0

    def __init__(self, target: Transform, velocity: Sequence[float], period_s: float) -> None:
        self._target = target
        self._step = [v * period_s for v in velocity]
        self._right = TOOL.inverse()

    def left(self, moment: Moment) -> Transform:
        x, y, z = (step * moment.tick for step in self._step)
        return Transform.translation(x, y, z) @ self._target

    def right(self, moment: Moment) -> Transform:
        return self._right

    def pose(self, moment: Moment) -> Transform:
        return self.left(moment) @ self._right


class WeavingGoal:
    """A target that weaves with t and rises with h, as functional transforms do; keeps moments."""

    constant = False
    cycle_s = math.tau / 4.0

    def __init__(self, target: Transform, width: float = 0.002, rise: float = 0.005) -> None:
        self._target = target
        self._width = width
        self._rise = rise
        self._right = TOOL.inverse()
        self.moments: list[Moment] = []

    def left(self, moment: Moment) -> Transform:
        self.moments.append(moment)
        y = self._width * math.sin(4.0 * moment.t)
        return Transform.translation(0.0, y, self._rise * moment.h**2) @ self._target

    def right(self, moment: Moment) -> Transform:
        return self._right

    def pose(self, moment: Moment) -> Transform:
        return self.left(moment) @ self._right


def float32(value: float) -> float:
    return float(struct.unpack("f", struct.pack("f", value))[0])


def over_the_wire(setpoint: CartesianSetpoint) -> CartesianSetpoint:
    """``setpoint`` as a node hears it: o, a, p, r, p and t_acc rounded to float32."""

    def rounded(pose: Transform) -> Transform:
        e = [float32(element) for element in pose]
        return Transform.from_o_a_p((e[1], e[5], e[9]), (e[2], e[6], e[10]), (e[3], e[7], e[11]))

    return setpoint._replace(
        T6_1=rounded(setpoint.T6_1),
        T6_2=None if setpoint.T6_2 is None else rounded(setpoint.T6_2),
        r=float32(setpoint.r),
        p=float32(setpoint.p),
        acceleration_time=float32(setpoint.acceleration_time),
    )


class Rig:
    """A PUMA 260 standing at ``q``: generator, six joints, and everything they said."""

    def __init__(
        self,
        blend: Blend = Blend.CONTINUOUS,
        period_s: float = TAU,
        q: Sequence[float] = HOME,
        *,
        wire: bool = False,
    ) -> None:
        self.period_s = period_s
        self.generator = TrajectoryGenerator(period_s, blend)
        self.joints = [JointSetpoint(period_s, theta) for theta in q]
        self.solvers = [JointSolver(PUMA_260, number) for number in range(1, 7)]
        self.wire = wire
        self.setpoints: list[CartesianSetpoint] = []
        self.stages: list[Stage] = []
        self.q: list[list[float]] = []
        self._sequence = 0
        start = (q[0], q[1], q[2], q[3], q[4], q[5])
        self.generator.enable(direct(PUMA_260, start), LEFT_DOWN)

    def ticks(self, duration_s: float) -> int:
        return whole_ticks(duration_s, self.period_s)

    def move(
        self,
        mode: Mode,
        name: str,
        segment_time: float,
        acceleration_time: float,
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
        *,
        transition: Transition = Transition.JOINT,
        configuration: Configuration = LEFT_DOWN,
    ) -> None:
        """Request a move of the tool to the golden position ``name``."""
        target = POSITIONS[name]
        goal = (
            FixedGoal(target, TOOL)
            if not any(velocity)
            else MovingGoal(target, velocity, self.period_s)
        )
        times = (segment_time, acceleration_time)
        self.move_to(mode, goal, *times, transition=transition, configuration=configuration)

    def move_to(
        self,
        mode: Mode,
        goal: Goal,
        segment_time: float,
        acceleration_time: float,
        *,
        transition: Transition = Transition.JOINT,
        configuration: Configuration = LEFT_DOWN,
    ) -> None:
        """Request a move to ``goal``."""
        self._sequence += 1
        segment, acceleration = self.ticks(segment_time), self.ticks(acceleration_time)
        self.generator.request(
            Move(self._sequence, goal, mode, segment, acceleration, configuration, transition)
        )

    def curve(
        self,
        name: str,
        segment_time: float,
        acceleration_time: float,
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Request a straight move with a Cartesian transition."""
        times = (segment_time, acceleration_time)
        self.move(Mode.CARTESIAN, name, *times, velocity, transition=Transition.CARTESIAN)

    def tick(self) -> list[float]:
        setpoint = self.generator.tick()
        if self.wire:
            setpoint = over_the_wire(setpoint)
        q = [
            joint.tick(setpoint, solver.solve)
            for joint, solver in zip(self.joints, self.solvers, strict=True)
        ]
        self.setpoints.append(setpoint)
        self.stages.append(self.generator.stage)
        self.q.append(q)
        return q

    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            self.tick()

    def run_to(self, stage: Stage, n: int | None = None, limit: int = 5000) -> None:
        """Until the last tick was of ``stage`` (and at its local tick ``n``)."""
        for _ in range(limit):
            self.tick()
            if self.generator.stage is stage and n in (None, self.setpoints[-1].n):
                return
        raise AssertionError(f"{stage} at n = {n} was not reached in {limit} ticks")

    def finish(self, limit: int = 5000) -> None:
        """Until at rest, and a dozen ticks more."""
        for _ in range(limit):
            self.tick()
            if self.generator.at_rest:
                self.run(12)
                return
        raise AssertionError(f"not at rest after {limit} ticks")

    def run_to_rest(self, limit: int = 20000) -> None:
        """Until the last tick was one at rest, or of a goal that goes on."""
        for _ in range(limit):
            self.tick()
            if self.generator.at_rest:
                return
        raise AssertionError(f"not at rest after {limit} ticks")

    def starts(self) -> list[int]:
        return [k for k, stage in enumerate(self.stages) if stage is Stage.START]

    def difference(self, order: int, around: int | None = None, reach: int = 8) -> float:
        """Largest difference quotient of ``order`` of any joint, ``reach`` ticks either side."""
        first = 0 if around is None else max(0, around - reach)
        last = None if around is None else around + reach
        quotients = np.diff(np.array(self.q[first:last]), n=order, axis=0) / self.period_s**order
        return float(np.max(np.abs(quotients)))


def golden_rig(name: str, blend: Blend, *, wire: bool = False) -> tuple[Rig, list[Any]]:
    """The golden program, requested, and its rows k, state, mode, n, h, r, p, q."""
    data: Mapping[str, Any] = golden(f"trajectory_{name}")
    rig = Rig(blend, data["tau"], data["q0"], wire=wire)
    modes = {"J": Mode.JOINT, "C": Mode.CARTESIAN}
    for move in data["moves"]:
        velocity = data["W3_velocity"] if move["target"] == "W3" else (0.0, 0.0, 0.0)
        rig.move(modes[move["mode"]], move["target"], move["tseg"], move["tacc"], velocity)
    return rig, data["rows"]


Floats = npt.NDArray[np.float64]
NODES = 8
"""Samples an angle between two samples is interpolated from."""


class Passage(NamedTuple):
    """From one hand-over to the next: local time, and six angles of each cycle."""

    n: Floats
    q: Floats


def passages(rig: Rig) -> list[Passage]:
    """The segments of a run, each with the transition into it; without cycles at rest."""
    found: list[tuple[list[float], list[list[float]]]] = []
    last, last_n = Stage.IDLE, 0.0
    for setpoint, stage, q in zip(rig.setpoints, rig.stages, rig.q, strict=True):
        if stage is not Stage.IDLE:
            begins = stage is Stage.CURVE and (last is not Stage.CURVE or setpoint.n < last_n)
            if stage is Stage.START or begins:
                found.append(([], []))
            found[-1][0].append(setpoint.n)
            found[-1][1].append(q)
        last, last_n = stage, setpoint.n
    return [Passage(np.array(n), np.array(q)) for n, q in found]


def interpolated(passage: Passage, n: Floats) -> Floats:
    """The angles at local times ``n``, by Lagrange's polynomial of the nearest samples."""
    first = np.clip(np.searchsorted(passage.n, n) - NODES // 2, 0, len(passage.n) - NODES)
    angles = np.zeros((len(n), 6))
    for row, (k, x) in enumerate(zip(first, n, strict=True)):
        nodes = passage.n[k : k + NODES]
        for i, node in enumerate(nodes):
            others = np.delete(nodes, i)
            angles[row] += np.prod((x - others) / (node - others)) * passage.q[k + i]
    return angles


def deviation(rig: Rig, nominal: Rig) -> float:
    """Largest distance, rad, between the angles of two runs at the same local times."""
    mine, reference = passages(rig), passages(nominal)
    assert len(mine) == len(reference)
    largest = 0.0
    for passage, whole in zip(mine, reference, strict=True):
        inside = (passage.n >= whole.n[0]) & (passage.n <= whole.n[-1])
        assert np.any(inside)
        apart = passage.q[inside] - interpolated(whole, passage.n[inside])
        largest = max(largest, float(np.max(np.abs(apart))))
    return largest
