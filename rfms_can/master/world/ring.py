"""Position equations as rings (thesis VI.4.3, Fig. 6.5).

The transforms of an equation stand in a ring, each where it takes one frame to the next: those of
the side of T6 forwards, those of the other side backwards, their inverses taken. All around
they multiply to the identity. So T6 is found by going round from its one end to its other, either
way: forwards is the inverse of the product, backwards the product of the inverses, and any frame of
the equation is reached from the arm both over its tool and over its base.
"""

from typing import Final, NamedTuple

from rfms_can.errors import EquationError
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world.transform_kinds import Live
from rfms_can.messages import T6, PositionMessage
from rfms_can.transform import Transform


class Link(NamedTuple):
    """One transform of a ring.

    Attributes:
        name: of the transform.
        source: a value, or what has one at a moment.
        inverted: whether going forwards takes its inverse.
    """

    name: str
    source: Transform | Live
    inverted: bool

    def reversed(self) -> "Link":
        """The link, met from its other end."""
        return self._replace(inverted=not self.inverted)


Links = tuple[Link, ...]


class Ring:
    """The links of an equation after T6, once round, and the places that have a name.

    A place is the number of links that lie between T6 and it, going forwards.

    Attributes:
        links: forwards: over the tool, the target and the base, back to where T6 begins.
        drive: place of the drive transform: at the end of the tool.
        comply: place of the frame the arm complies in.
    """

    __slots__ = ("comply", "drive", "links")

    def __init__(self, message: PositionMessage, sources: dict[str, Transform | Live]) -> None:
        """Close the ring of an equation.

        Args:
            message: the equation.
            sources: of all transforms in it, by name.

        Raises:
            EquationError: T6 does not stand in it once, or tool or compliance frame do not fit.
        """
        name = f"position {message.name!r}"
        count = message.left.count(T6) + message.right.count(T6)
        if count != 1:
            raise EquationError(f"{name}: {T6} stands {count} times; it must stand once")
        sides = (message.left, message.right)
        own, other = sides if T6 in message.left else (sides[1], sides[0])
        place = own.index(T6)
        before, after = own[:place], own[place + 1 :]
        forwards = [Link(each, sources[each], False) for each in after]
        backwards = [Link(each, sources[each], True) for each in reversed(other)]
        rest = [Link(each, sources[each], False) for each in before]
        self.links: Final[Links] = (*forwards, *backwards, *rest)
        self.drive: Final = len(after) if message.tool is None else 1
        if message.tool is not None and message.tool not in after[:1]:
            raise EquationError(f"{name}: tool {message.tool!r} must stand right after {T6}")
        self.comply: Final = self._place_of(name, message.compliance)

    def _place_of(self, name: str, frame: str | None) -> int:
        """Place of the frame a transform ends in; of the tool's by default."""
        if frame is None:
            return self.drive
        if frame == T6:
            return 0
        places = [k for k, link in enumerate(self.links) if link.name == frame]
        if len(places) != 1:
            raise EquationError(
                f"{name}: compliance {frame!r} must stand in the equation once, it stands "
                f"{len(places)} times; name one of its transforms"
            )
        return places[0] if self.links[places[0]].inverted else places[0] + 1

    def forwards(self, place: int) -> Links:
        """The links from T6 to ``place``: to its frame over the tool."""
        return self.links[:place]

    def backwards(self, place: int) -> Links:
        """The links from the other end of T6 to ``place``: to its frame over the base."""
        return tuple(link.reversed() for link in reversed(self.links[place:]))

    @property
    def left(self) -> Links:
        """L of T6 = L D R: over the base to the drive transform."""
        return self.backwards(self.drive)

    @property
    def right(self) -> Links:
        """R: from there back over the tool."""
        return tuple(link.reversed() for link in reversed(self.forwards(self.drive)))


class Chain:
    """The product of links, kept as far as it is valid.

    Values that stand side by side are multiplied once and for all. A product of the ones before is
    kept at every link: only what stands right of a change is computed again.
    """

    __slots__ = ("_factors", "_products", "_values")

    def __init__(self, links: Links) -> None:
        self._factors: Final[list[Link]] = _premultiplied(links)
        self._values: list[Transform | None] = [None] * len(self._factors)
        self._products = [Transform.identity()] * len(self._factors)

    @property
    def constant(self) -> bool:
        """Whether it is the same at every moment."""
        return all(isinstance(factor.source, Transform) for factor in self._factors)

    @property
    def cycle_s(self) -> float:
        """Time in which it shows all it does, s; 0 where time alone does not change it."""
        sources = (factor.source for factor in self._factors)
        cycles = (0.0 if isinstance(source, Transform) else source.cycle_s for source in sources)
        return max(cycles, default=0.0)

    def at(self, moment: Moment) -> Transform:
        """The product; the same object while it does not change."""
        valid = True
        product = None
        values, products = self._values, self._products
        for k, (_, source, inverted) in enumerate(self._factors):
            if isinstance(source, Transform):
                value = source
            else:
                value = source.inverse_at(moment) if inverted else source.at(moment)
            if not valid or value is not values[k]:
                valid = False
                values[k] = value
                products[k] = value if product is None else product @ value
            product = products[k]
        return Transform.identity() if product is None else product


def _premultiplied(links: Links) -> list[Link]:
    """The links, with values upright and those side by side in one."""
    factors: list[Link] = []
    product: Transform | None = None
    for link in links:
        source = link.source
        if isinstance(source, Transform):
            value = source.inverse() if link.inverted else source
            product = value if product is None else product @ value
            continue
        if product is not None:
            factors.append(Link("", product, False))
        product = None
        factors.append(link)
    return factors if product is None else [*factors, Link("", product, False)]
