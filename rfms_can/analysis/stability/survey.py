"""A study over many poses: along a path, over a grid of two joints, or at random."""

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from random import Random
from typing import NamedTuple

import numpy as np

from rfms_can.analysis.stability.continuous import Verdict
from rfms_can.analysis.stability.study import Analysis, Analyst, Study
from rfms_can.arm import JOINT_COUNT, Arm
from rfms_can.errors import RfmsError

Pose = tuple[float, ...]
Advance = Callable[[], None]


class Survey(NamedTuple):
    """The analyses, in the order of the poses."""

    study: Study
    analyses: tuple[Analysis, ...]

    @property
    def unstable(self) -> int:
        """Number of poses at which the continuous loop is unstable."""
        return sum(a.verdict is Verdict.UNSTABLE for a in self.analyses)

    @property
    def unstable_sampled(self) -> int:
        """Number of poses at which the sampled loop is unstable."""
        return sum(not a.sampled_stable for a in self.analyses)

    @property
    def drifting(self) -> int:
        """Number of poses at which a disturbance neither grows nor decays."""
        return sum(a.on_the_bus is Verdict.DRIFTS for a in self.analyses)

    @property
    def conflicting(self) -> int:
        """Number of poses at which C_theta was damped."""
        return sum(bool(a.conflicts) for a in self.analyses)

    @property
    def worst(self) -> Analysis:
        """The pose with the largest real part."""
        return max(self.analyses, key=lambda a: a.growth)


class Grid(NamedTuple):
    """Poses over two joints.

    Attributes:
        joints: their indices (0 to 5).
        first, second: their angles, rad.
        poses: row by row: one angle of the first joint, all of the second.
    """

    joints: tuple[int, int]
    first: tuple[float, ...]
    second: tuple[float, ...]
    poses: tuple[Pose, ...]


def survey(study: Study, poses: Iterable[Pose], advance: Advance = lambda: None) -> Survey:
    """Analyse every pose; ``advance`` is called after each."""
    analyst, found = Analyst(study), []
    for q in poses:
        found.append(analyst.analyse(q))
        advance()
    return Survey(study, tuple(found))


def grid_poses(arm: Arm, joints: tuple[int, int], points: int, base: Sequence[float]) -> Grid:
    """A grid over the whole range of two joints, the others as in ``base``.

    Args:
        arm: whose limits bound it.
        joints: two indices, 0 to 5.
        points: along either side.
        base: six joint angles, rad.

    Raises:
        RfmsError: not two different joints, or too few points.
    """
    a, b = joints
    if a == b or not {a, b} <= set(range(JOINT_COUNT)):
        raise RfmsError(f"grid over joints {a + 1} and {b + 1}: give two different ones of 1 to 6")
    if not 2 <= points <= 1000:
        raise RfmsError(f"grid of {points} points a side: give 2 to 1000")
    sides = [np.linspace(*arm.joint_limits[j], points).tolist() for j in joints]
    poses = []
    for x in sides[0]:
        for y in sides[1]:
            q = list(base)
            q[a], q[b] = x, y
            poses.append(tuple(q))
    return Grid(joints, tuple(sides[0]), tuple(sides[1]), tuple(poses))


def random_poses(arm: Arm, count: int, seed: int) -> tuple[Pose, ...]:
    """Poses drawn evenly from the joints' ranges; the same for the same seed.

    Raises:
        RfmsError: not 1 to 100 000 of them.
    """
    if not 1 <= count <= 100_000:
        raise RfmsError(f"{count} random poses: give 1 to 100000")
    random = Random(seed)
    return tuple(
        tuple(random.uniform(lower, upper) for lower, upper in arm.joint_limits)
        for _ in range(count)
    )


def path_poses(path: Path, arm: Arm) -> tuple[Pose, ...]:
    """Poses of a file: six angles a line, rad, apart by blanks or commas; # begins a comment.

    Raises:
        RfmsError: the file cannot be read, or a line is not a pose of the arm.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise RfmsError(f"path {path}: {error}") from error
    poses = []
    for number, line in enumerate(lines, start=1):
        words = re.split(r"[\s,]+", line.split("#")[0].strip(" ,\t"))
        if words != [""]:
            poses.append(_pose(words, arm, f"path {path}, line {number}"))
    if not poses:
        raise RfmsError(f"path {path} has no pose: give six angles (rad) a line")
    return tuple(poses)


def parse_pose(text: str, arm: Arm) -> Pose:
    """Six angles, rad, apart by commas or blanks.

    Raises:
        RfmsError: it is not six numbers, each in the range of its joint.
    """
    return _pose(re.split(r"[\s,]+", text.strip(" ,")), arm, "pose")


def _pose(words: Sequence[str], arm: Arm, where: str) -> Pose:
    try:
        q = tuple(float(word) for word in words)
    except ValueError:
        q = ()
    if len(q) != JOINT_COUNT:
        raise RfmsError(f"{where}: {' '.join(words)!r} is not a pose: give six angles in rad")
    for joint, (angle, (lower, upper)) in enumerate(zip(q, arm.joint_limits, strict=True), 1):
        if not lower <= angle <= upper:  # also NaN
            raise RfmsError(
                f"{where}: joint {joint} of {arm.name} at {angle:g} rad is not in its range, "
                f"{lower:.4g} to {upper:.4g}"
            )
    return q
