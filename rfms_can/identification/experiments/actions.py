"""Motions of an experiment, and its program.

An ordinary program: positions from the kinematics, moves planned or refused by the master. It marks
the cycles of each motion, so that an analysis can assign the frames.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, assert_never

from rfms_can.arm import Arm as ArmData
from rfms_can.coordinator import Arm
from rfms_can.kinematics import configuration_of, direct
from rfms_can.rig.session import Program

Pose = tuple[float, float, float, float, float, float]

SWEEP: Final = "sweep"
CREEP: Final = "creep"
BURST: Final = "burst"
TOUR: Final = "tour"

TRANSIT_SPEED: Final = 0.95
"""Fraction of the joints' speed limits on the way to the start of an experiment."""
TRANSIT_ACCELERATION_S: Final = 0.3
SWEEP_ACCELERATION_S: Final = 0.12
RISE: Final = 1.875
"""Largest over mean acceleration of a matching polynomial."""
EASE: Final = 0.95
"""Fraction of its limits that a burst uses."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """Constant speed of one joint, in both directions.

    Attributes:
        joint: 1 to 6.
        pose: of the others, rad (6).
        lower, upper: reversal points, rad.
        speed: rad/s.
    """

    joint: int
    pose: Pose
    lower: float
    upper: float
    speed: float


@dataclass(frozen=True, slots=True)
class Creep(Sweep):
    """A sweep short and slow enough to show the breakaway of the joint."""


@dataclass(frozen=True, slots=True)
class Burst:
    """Motion of one joint in both directions at its acceleration limit.

    Attributes:
        joint: 1 to 6.
        pose: initial pose, rad (6).
        displacement: of the joint, rad; signed.
        times: number of repetitions, there and back.
    """

    joint: int
    pose: Pose
    displacement: float
    times: int = 2


@dataclass(frozen=True, slots=True)
class Tour:
    """All joints at once, from pose to pose.

    Attributes:
        places: rad (6 each).
        joint_speed: fraction of the speed limits.
        acceleration_time: t_acc, s.
    """

    places: tuple[Pose, ...]
    joint_speed: float
    acceleration_time: float


Action = Sweep | Burst | Tour


@dataclass(frozen=True, slots=True)
class Mark:
    """One motion of an experiment.

    Attributes:
        kind: of the action.
        joint: that moves, 1 to 6; 0 for all.
        action: index in the experiment.
        start, stop: control cycles since enable, [start, stop).
    """

    kind: str
    joint: int
    action: int
    start: int
    stop: int


class Stage:
    """Moves an arm by joint angles, and marks the cycles.

    Args:
        arm: the program's.
        data: the arm's kinematics.

    Attributes:
        marks: of all motions so far.
    """

    def __init__(self, arm: Arm, data: ArmData) -> None:
        self.marks: list[Mark] = []
        self._arm = arm
        self._data = data
        self._places: dict[Pose, str] = {}
        self._modes: dict[tuple[float, float | None, float | None], str] = {}

    def go(
        self,
        pose: Sequence[float],
        acceleration_time: float,
        *,
        segment_time: float | None = None,
        joint_speed: float | None = None,
    ) -> None:
        """Move to joint angles (6, rad) in joint mode, and wait."""
        arm = self._arm
        arm.wait(
            arm.move(self._place(pose), self._mode(acceleration_time, segment_time, joint_speed))
        )

    def transit(self, pose: Sequence[float]) -> None:
        """Move to the start of an experiment."""
        self.go(pose, TRANSIT_ACCELERATION_S, joint_speed=TRANSIT_SPEED)

    def mark(self, kind: str, joint: int, action: int, motion: Callable[[], None]) -> None:
        """Mark a motion."""
        start = self._arm.status.cycle
        motion()
        self.marks.append(Mark(kind, joint, action, start, self._arm.status.cycle))

    def _place(self, pose: Sequence[float]) -> str:
        key: Pose = tuple(pose)  # type: ignore[assignment]
        if key not in self._places:
            arm, name = self._arm, f"place {len(self._places)}"
            there = arm.transform(name, direct(self._data, pose))
            words = str(configuration_of(self._data, pose))
            self._places[key] = arm.position(name, arm.t6 == there, config=words)
        return self._places[key]

    def _mode(
        self, acceleration_time: float, segment_time: float | None, joint_speed: float | None
    ) -> str:
        key = (acceleration_time, segment_time, joint_speed)
        if key not in self._modes:
            self._modes[key] = self._arm.mode(
                f"mode {len(self._modes)}",
                acceleration_time=acceleration_time,
                segment_time=segment_time,
                joint_speed=joint_speed,
                lengthen=True,
            )
        return self._modes[key]


def program_of(actions: Sequence[Action], data: ArmData, marks: list[Mark]) -> Program:
    """The program of an experiment; it appends to ``marks`` while it runs."""

    def program(arm: Arm) -> None:
        stage = Stage(arm, data)
        stage.marks = marks
        for index, action in enumerate(actions):
            match action:
                case Sweep():
                    _sweep(stage, index, action)
                case Burst():
                    _burst(stage, index, action, data)
                case Tour():
                    _tour(stage, index, action)
                case _:
                    assert_never(action)

    return program


def with_joint(pose: Pose, joint: int, angle: float) -> Pose:
    """The pose with the angle of one joint (1 to 6) replaced."""
    angles = list(pose)
    angles[joint - 1] = angle
    return tuple(angles)  # type: ignore[return-value]


def _sweep(stage: Stage, index: int, sweep: Sweep) -> None:
    ends = [with_joint(sweep.pose, sweep.joint, angle) for angle in (sweep.upper, sweep.lower)]
    stage.transit(ends[1])
    seconds = (sweep.upper - sweep.lower) / sweep.speed
    kind = CREEP if isinstance(sweep, Creep) else SWEEP
    for end in ends:
        stage.mark(
            kind,
            sweep.joint,
            index,
            lambda end=end: stage.go(end, SWEEP_ACCELERATION_S, segment_time=seconds),  # type: ignore[misc]
        )


def _burst(stage: Stage, index: int, burst: Burst, data: ArmData) -> None:
    i = burst.joint - 1
    here, there = (
        burst.pose,
        with_joint(burst.pose, burst.joint, burst.pose[i] + burst.displacement),
    )
    stage.transit(here)
    acceleration, segment = burst_times(abs(burst.displacement), data, burst.joint)
    for end in (there, here) * burst.times:
        stage.mark(
            BURST,
            burst.joint,
            index,
            lambda end=end: stage.go(end, acceleration, segment_time=segment),  # type: ignore[misc]
        )


def burst_times(distance: float, data: ArmData, joint: int) -> tuple[float, float]:
    """t_acc and t_seg, s, of a burst over ``distance`` (rad): at the limits or just below."""
    speed = EASE * data.speed_limits[joint - 1]
    acceleration = EASE * data.acceleration_limits[joint - 1]
    to_speed = RISE * speed / acceleration
    segment = distance / speed + to_speed / 2.0
    if distance < speed * to_speed:
        segment = (2.0 * RISE * distance / acceleration) ** 0.5
    return max(to_speed / 2.0, 0.04), max(segment, 0.16)


def _tour(stage: Stage, index: int, tour: Tour) -> None:
    first, *others = tour.places
    stage.transit(first)
    for place in others:
        stage.mark(
            TOUR,
            0,
            index,
            lambda place=place: stage.go(  # type: ignore[misc]
                place, tour.acceleration_time, joint_speed=tour.joint_speed
            ),
        )
