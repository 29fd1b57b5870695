"""Positions: equations solved for T6, and the goals that moves to them have."""

import math
from typing import Final

from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import FixedGoal, Goal, Moment
from rfms_can.master.world.reference import Reference
from rfms_can.master.world.ring import Chain, Link, Links, Ring
from rfms_can.master.world.transform_kinds import Functional, FunctionalSymbol
from rfms_can.transform import Transform


class RingGoal:
    """The goal of a ring with transforms in it that move: T6 = L D R."""

    __slots__ = ("_ends", "_left", "_pose", "_right")

    constant = False

    def __init__(self, left: Chain, right: Chain) -> None:
        self._left: Final = left
        self._right: Final = right
        self._ends: tuple[Transform, Transform] | None = None
        self._pose = Transform.identity()

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
    """A solved position equation.

    Attributes:
        name: as defined.
        configuration: branch of the inverse solution.
    """

    __slots__ = ("_comply", "_functions", "_goal", "_rides", "_ring", "configuration", "name")

    def __init__(self, name: str, ring: Ring, configuration: Configuration) -> None:
        self.name: Final = name
        self.configuration: Final = configuration
        self._ring: Final = ring
        self._rides: Final = ring.comply <= ring.drive
        self._functions: list[Functional] = []
        self._solve()

    @property
    def goal(self) -> Goal:
        """T6 = L D R, for a move that is requested now.

        It follows its references; its functional transforms stay what they are now, whatever is
        defined later. So a function that is redefined changes the moves requested from then on,
        and never the curve of one that is promised.
        """
        if self._current() != self._functions:
            self._solve()
        return self._goal

    @property
    def references(self) -> tuple[str, ...]:
        """Names of the references in the equation."""
        return tuple(link.name for link in self._ring.links if isinstance(link.source, Reference))

    def uses(self, transform: str) -> bool:
        """Whether a transform stands in the equation."""
        return any(link.name == transform for link in self._ring.links)

    def compliance_frame(self, moment: Moment, T6: Transform) -> Transform:
        """The frame the arm complies in, seen from T6.

        One on the tool's side of the drive transform rides on the arm; any other stands in the
        world, or moves as its transforms do, and is seen from where the arm is.

        Args:
            moment: when.
            T6: where the arm is.
        """
        if self._current() != self._functions:
            self._solve()
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
                    beyond = Chain(self._bound(links[k if link.inverted else k + 1 :])).at(moment)
                    arm = math.hypot(beyond.px, beyond.py, beyond.pz)
                    levers[link.name] = max(arm, levers.get(link.name, 0.0))
        return levers

    def _solve(self) -> None:
        ring = self._ring
        self._functions = self._current()
        left, right = Chain(self._bound(ring.left)), Chain(self._bound(ring.right))
        links = ring.forwards(ring.comply) if self._rides else ring.backwards(ring.comply)
        self._comply = Chain(self._bound(links))
        self._goal: Goal = RingGoal(left, right)
        if left.constant and right.constant:
            nowhere = Moment(0)
            self._goal = FixedGoal(left.at(nowhere), right.at(nowhere).inverse())

    def _current(self) -> list[Functional]:
        sources = (link.source for link in self._ring.links)
        return [source.current for source in sources if isinstance(source, FunctionalSymbol)]

    def _bound(self, links: Links) -> Links:
        """The links with functional transforms as they are now."""
        return tuple(_bound(link) for link in links)


def _bound(link: Link) -> Link:
    if isinstance(link.source, FunctionalSymbol):
        return link._replace(source=link.source.current)
    return link
