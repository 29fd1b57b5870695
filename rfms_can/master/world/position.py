"""Positions: equations solved for T6, and the goals that moves to them have."""

import math
from collections.abc import Mapping
from typing import Final
from weakref import ReferenceType, ref

from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import FixedGoal, Goal, Moment
from rfms_can.master.world.reference import Reference
from rfms_can.master.world.ring import Chain, Ring
from rfms_can.master.world.transform_kinds import Live
from rfms_can.messages import T6, PositionMessage
from rfms_can.transform import Transform

_NOWHERE: Final = Moment(0)
"""Where a goal that never moves is evaluated."""


class RingGoal:
    """The goal of a ring with transforms in it that move: T6 = L D R."""

    __slots__ = ("_ends", "_left", "_pose", "_right")

    constant = False

    def __init__(self, left: Chain, right: Chain) -> None:
        self._left: Final = left
        self._right: Final = right
        self._ends: tuple[Transform, Transform] | None = None
        self._pose = Transform.identity()

    @property
    def cycle_s(self) -> float:
        """Time in which it shows all it does, s."""
        return max(self._left.cycle_s, self._right.cycle_s)

    def left(self, moment: Moment) -> Transform:
        """L: over the base to the drive transform."""
        return self._left.at(moment)

    def right(self, moment: Moment) -> Transform:
        """R: from there back over the tool."""
        return self._right.at(moment)

    def pose(self, moment: Moment) -> Transform:
        """L R: T6 at the goal."""
        left, right = self._left.at(moment), self._right.at(moment)
        ends = self._ends
        if ends is None or left is not ends[0] or right is not ends[1]:
            self._ends, self._pose = (left, right), left @ right
        return self._pose


class Position:
    """A position equation solved with the transforms of one moment; it never changes.

    References in it are followed; values and functions are those it was bound to, whatever is
    defined later.

    Attributes:
        name: as defined.
        configuration: branch of the inverse solution.
        goal: T6 = L D R.
        references: the names of the references in it.
    """

    __slots__ = (
        *("__weakref__", "_comply", "_rides", "_ring"),
        *("configuration", "goal", "name", "references"),
    )

    def __init__(self, name: str, ring: Ring, configuration: Configuration) -> None:
        self.name: Final = name
        self.configuration: Final = configuration
        self._ring: Final = ring
        self._rides: Final = ring.comply <= ring.drive
        self.references: Final = tuple(
            dict.fromkeys(link.name for link in ring.links if isinstance(link.source, Reference))
        )
        left, right = Chain(ring.left), Chain(ring.right)
        links = ring.forwards(ring.comply) if self._rides else ring.backwards(ring.comply)
        self._comply: Final = Chain(links)
        self.goal: Final[Goal] = (
            FixedGoal(left.at(_NOWHERE), right.at(_NOWHERE).inverse())
            if left.constant and right.constant
            else RingGoal(left, right)
        )

    def uses(self, transform: str) -> bool:
        """Whether a transform stands in the equation."""
        return any(link.name == transform for link in self._ring.links)

    def is_bound_to(self, table: Mapping[str, Transform | Live]) -> bool:
        """Whether its transforms are those of a table."""
        return all(link.source is table[link.name] for link in self._ring.links)

    def is_same(self, other: object) -> bool:
        """Whether both are of one equation, and bound to the same transforms."""
        if not isinstance(other, Position):
            return False
        mine, its = self._ring, other._ring
        return (mine.drive, mine.comply, self.configuration) == (
            *(its.drive, its.comply, other.configuration),
        ) and mine.links == its.links

    def compliance_frame(self, moment: Moment, T6: Transform) -> Transform:
        """The frame the arm complies in, seen from T6.

        One on the tool's side of the drive transform rides on the arm; any other stands in the
        world, or moves as its transforms do, and is seen from where the arm is.

        Args:
            moment: when.
            T6: where the arm is.
        """
        frame = self._comply.at(moment)
        return frame if self._rides else T6.inverse() @ frame

    def tool(self, moment: Moment) -> Transform:
        """The frame right of T6 that runs along straight lines, seen from T6."""
        return self.goal.right(moment).inverse()

    def levers(self, moment: Moment) -> dict[str, float]:
        """How far, m, from its references is what they move.

        It is the origin of the tool for those left of the drive transform, of T6 for the others.
        """
        levers: dict[str, float] = {}
        for links in (self._ring.left, self._ring.right):
            for k, link in enumerate(links):
                if isinstance(link.source, Reference):
                    # the rotation of a correction acts at the right of the transform
                    beyond = Chain(links[k if link.inverted else k + 1 :]).at(moment)
                    arm = math.hypot(beyond.px, beyond.py, beyond.pz)
                    levers[link.name] = max(arm, levers.get(link.name, 0.0))
        return levers


class PositionEquation:
    """What the name of a position stands for: an equation between names of transforms.

    It is solved when it is needed, and the solution is kept by what needs it: tables may be large.

    Attributes:
        message: as defined.
        configuration: branch of the inverse solution.
        transforms: their names.
    """

    __slots__ = ("_bound", "configuration", "message", "transforms")

    def __init__(self, message: PositionMessage, configuration: Configuration) -> None:
        self.message: Final = message
        self.configuration: Final = configuration
        names = dict.fromkeys((*message.left, *message.right))
        self.transforms: Final = tuple(name for name in names if name != T6)
        self._bound: ReferenceType[Position] | None = None

    def bind(self, table: Mapping[str, Transform | Live]) -> Position:
        """The equation solved with what its names stand for now; the same while that does not
        change.

        Args:
            table: the transforms by name; those of the equation are in it.

        Raises:
            EquationError: T6 does not stand in it once, or tool or compliance frame do not fit.
        """
        bound = None if self._bound is None else self._bound()
        if bound is None or not bound.is_bound_to(table):
            sources = {name: table[name] for name in self.transforms}
            bound = Position(self.message.name, Ring(self.message, sources), self.configuration)
            self._bound = ref(bound)
        return bound
