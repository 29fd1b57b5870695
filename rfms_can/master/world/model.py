"""The world model: symbol tables of transforms, positions and modes (thesis VI.4.1, VI.4.3)."""

from collections.abc import Callable, Mapping
from itertools import islice
from typing import Any, Final, NamedTuple, get_args

from rfms_can.errors import EquationError, KinematicsError, ModeError, ProgramError, TransformError
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world.joint_position import JointPosition
from rfms_can.master.world.modes import Limits, MotionMode
from rfms_can.master.world.position import Position, PositionEquation
from rfms_can.master.world.reference import Reference
from rfms_can.master.world.tables import MAX_MODES, MAX_POSITIONS, SymbolTable
from rfms_can.master.world.transforms import Transforms
from rfms_can.messages import (
    NAMES_LISTED,
    T6,
    JointPositionMessage,
    ModeMessage,
    PositionMessage,
    RemoveRequest,
    TransformMessage,
    WorldNames,
)
from rfms_can.messages.world import What
from rfms_can.tables import complete

Definition = TransformMessage | PositionMessage | JointPositionMessage | ModeMessage
AnyPosition = Position | JointPosition
"""Where a move may go."""


class WorldModel:
    """What names stand for; what uses a name takes it as it is when it is bound to it.

    Args:
        configuration: what a position takes that names none.
        period_s: of the ticks, s; the server's time is tick times period.
    """

    def __init__(self, configuration: Configuration, period_s: float) -> None:
        self.configuration = configuration
        self._transforms: Final = Transforms(period_s)
        self._positions: Final = SymbolTable[PositionEquation | JointPosition](
            "position", MAX_POSITIONS, EquationError
        )
        self._modes: Final = SymbolTable[MotionMode]("mode", MAX_MODES, ModeError)
        self._users: Final[dict[str, dict[str, None]]] = {}

    # --- definitions --------------------------------------------------------------------------

    def define_transform(
        self, message: TransformMessage, tick: int = 0, limits: Limits | None = None
    ) -> None:
        """Enter a transform, redefine it, or take an observation of it.

        A value or a function acts on the positions that are bound from then on, a reference on
        everything that uses it, from the set-point of ``tick`` on.

        Args:
            message: the definition.
            tick: of the next set-point: the first it can act in.
            limits: of the mode the arm moves with if what moves uses this transform: a jump is
                then faded within them. Without, it jumps.

        Raises:
            TransformError: not a rotation, a number not finite or out of bounds, a table whose u
                does not grow, a stamp of the future or too old, another kind than before, a name
                taken by the arm, or one too many. Nothing has changed.
        """
        self._transforms.define(message, tick, limits)

    def silent(self, tick: int) -> list[str]:
        """References that move on although an observation of them is overdue."""
        return self._transforms.silent(tick)

    def last_observed(self, name: str) -> str | None:
        """What was observed of a reference last, in words; None of one that was not."""
        return self._transforms.last_observed(name)

    def settle_transform(self, name: str, tick: int, limits: Limits | None) -> None:
        """Bring a reference that is not observed any more to rest, in the time it states.

        Args:
            name: of a transform; one that does not move rests.
            tick: of the next set-point.
            limits: of the mode the arm moves with; None if nothing that moves uses it.
        """
        self._transforms.settle(name, tick, limits)

    def halt_transform(self, name: str, tick: int, limits: Limits) -> None:
        """Bring a reference that moves to rest as soon as the limits allow.

        It stays until it is observed again.

        Args:
            name: of a transform that is defined.
            tick: of the next set-point.
            limits: of the mode the arm moves with.
        """
        self._transforms.halt(name, tick, limits)

    def define_position(self, message: PositionMessage) -> Position:
        """Enter a position equation, or define it again; solved for T6 as it is now.

        Raises:
            EquationError: not exactly one T6, an unknown transform, a tool or compliance frame
                that is not in it, or one too many. Nothing has changed.
        """
        name = message.name
        known = self._positions.get(name)
        if known is None:
            self._positions.check_room(name)
        words = message.configuration
        try:
            configuration = self.configuration if words is None else Configuration.parse(words)
        except KinematicsError as error:
            raise EquationError(f"position {name!r}: {error}") from error
        table = self._transforms.table
        if not isinstance(known, PositionEquation) or (known.message, known.configuration) != (
            message,
            configuration,
        ):
            known = PositionEquation(message, configuration)
            for transform in known.transforms:
                if transform not in table:
                    raise EquationError(
                        f"position {name!r}: transform {transform!r} is not defined; "
                        f"{table.listing()}"
                    )
        position = known.bind(table)
        self._enter(known)
        return position

    def define_joint_position(self, position: JointPosition) -> None:
        """Enter a position in joint coordinates, or define it again.

        Raises:
            EquationError: one too many. Nothing has changed.
        """
        if position.name not in self._positions:
            self._positions.check_room(position.name)
        self._enter(position)

    def define_mode(self, message: ModeMessage) -> MotionMode:
        """Enter a mode, or define it again.

        Raises:
            ModeError: it contradicts itself, or one too many. Nothing has changed.
        """
        name = message.name
        known = self._modes.get(name)
        if known is None:
            self._modes.check_room(name)
        mode = MotionMode.from_message(message)
        if mode == known:
            return known
        self._modes[name] = mode
        return mode

    def note_levers(self, position: AnyPosition, tick: int) -> None:
        """Corrections of its references are to mind how far from them a position is.

        Args:
            position: one that was accepted.
            tick: of the next set-point.
        """
        for transform, lever in position.levers(Moment(tick)).items():
            reference = self._transforms.table.get(transform)
            if isinstance(reference, Reference):
                reference.lever = max(reference.lever, lever)

    # --- taking back --------------------------------------------------------------------------

    def former(self, message: Definition) -> "Former":
        """What a name stands for, before it is defined again."""
        what = _DEFINES[type(message)]
        return Former(what, message.name, _TABLES[what](self).get(message.name))

    def differs(self, former: "Former") -> bool:
        """Whether a name that was known stands for anything else now; a reference never does."""
        now = _TABLES[former.what](self).get(former.name)
        return former.entry is not None and now is not former.entry

    def restore(self, former: "Former") -> None:
        """Let a name that was known stand for what it stood for."""
        if former.what == "position":
            self._enter(former.entry)
        else:
            _TABLES[former.what](self)[former.name] = former.entry

    # --- removal ------------------------------------------------------------------------------

    def entry_of(self, request: RemoveRequest) -> "Former":
        """What is to be removed: the one thing of its name, if the request does not say what.

        Raises:
            ProgramError: there is none of that name, or a position still uses it; or several, and
                the request does not say which.
        """
        name, what = request.name, request.what
        if name == T6 and what in (None, "transform"):
            raise TransformError(f"transform {T6!r} is the arm itself and cannot be removed")
        if what is None:
            found = [each for each, table in _TABLES.items() if name in table(self)]
            if len(found) != 1:
                raise ProgramError(
                    f"remove {name!r}: it is the name of a {' and of a '.join(found)}; say which"
                    if found
                    else f"remove {name!r}: no transform, position or mode has this name"
                )
            (what,) = found
        entry = _TABLES[what](self).known(name)
        users = self._users.get(name) if what == "transform" else None
        if users:
            more = f" and {len(users) - 1} more" if len(users) > 1 else ""
            raise TransformError(
                f"transform {name!r} is used by position {next(iter(users))!r}{more}: remove that, "
                f"or define it without this transform, first"
            )
        return Former(what, name, entry)

    def remove(self, former: "Former") -> None:
        """Forget a name that nothing uses."""
        if former.what == "position":
            self._leave(former.entry)
        if former.what == "transform":
            self._transforms.remove(former.name)
        else:
            del _TABLES[former.what](self)[former.name]

    # --- names --------------------------------------------------------------------------------

    def position(self, name: str) -> AnyPosition:
        """A position by name, solved as it is now; ``ProgramError`` lists those that exist."""
        return self._positions.look_up(name).bind(self._transforms.table)

    def mode(self, name: str) -> MotionMode:
        """A mode by name; ``ProgramError`` lists those that exist."""
        return self._modes.look_up(name)

    def names(self, start: int = 0) -> WorldNames:
        """What there is: of each table the names from ``start`` on, ``NAMES_LISTED`` at most."""
        end = start + NAMES_LISTED
        transforms, positions, modes = (
            dict(islice(self._transforms.kinds.items(), start, end)),
            list(islice(self._positions, start, end)),
            list(islice(self._modes, start, end)),
        )
        sizes = {what: len(table(self)) for what, table in _TABLES.items()}
        return WorldNames(transforms, positions, modes, sizes)

    # --- who uses what ------------------------------------------------------------------------

    def _enter(self, entry: PositionEquation | JointPosition) -> None:
        """Enter a position, in the place of what its name stood for."""
        name = entry.message.name
        before = self._positions.get(name)
        if before is entry:
            return
        if before is not None:
            self._leave(before)
        self._positions[name] = entry
        for transform in entry.transforms:
            self._users.setdefault(transform, {})[name] = None

    def _leave(self, entry: PositionEquation | JointPosition) -> None:
        """A position uses its transforms no more."""
        for transform in entry.transforms:
            users = self._users[transform]
            del users[entry.message.name]
            if not users:
                del self._users[transform]


class Former(NamedTuple):
    """What a name stood for.

    Attributes:
        what: it named.
        name: of that.
        entry: that; None if there was none.
    """

    what: What
    name: str
    entry: Any


_TABLES: Final[Mapping[What, Callable[[WorldModel], SymbolTable[Any]]]] = complete(
    {
        "transform": lambda world: world._transforms.table,
        "position": lambda world: world._positions,
        "mode": lambda world: world._modes,
    },
    get_args(What),
)
"""The table of what is named."""

_DEFINES: Final[Mapping[type[Definition], What]] = {
    TransformMessage: "transform",
    PositionMessage: "position",
    JointPositionMessage: "position",
    ModeMessage: "mode",
}
"""What a message defines."""
