"""The world model: symbol tables of transforms, positions and modes (thesis VI.4.1, VI.4.3)."""

from typing import Final

from rfms_can.errors import EquationError, KinematicsError, ModeError
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world.modes import Limits, MotionMode
from rfms_can.master.world.position import Position
from rfms_can.master.world.reference import Reference
from rfms_can.master.world.ring import Ring
from rfms_can.master.world.tables import MAX_MODES, MAX_POSITIONS, SymbolTable
from rfms_can.master.world.transform_kinds import Live
from rfms_can.master.world.transforms import Transforms
from rfms_can.messages import T6, ModeMessage, PositionMessage, TransformMessage, WorldNames
from rfms_can.transform import Transform


class WorldModel:
    """Transforms may be redefined; a position or a mode only once, as the thesis has it.

    Args:
        configuration: what a position takes that names none.
        period_s: of the ticks, s; the server's time is tick times period.
    """

    def __init__(self, configuration: Configuration, period_s: float) -> None:
        self.configuration = configuration
        self._transforms: Final = Transforms(period_s)
        self._positions: Final = SymbolTable[Position]("position", MAX_POSITIONS, EquationError)
        self._modes: Final = SymbolTable[MotionMode]("mode", MAX_MODES, ModeError)

    def define_transform(
        self, message: TransformMessage, tick: int = 0, limits: Limits | None = None
    ) -> None:
        """Enter a transform, redefine it, or take an observation of it.

        A value acts on positions defined later, a function on moves requested later, a reference
        on everything that uses it, from the set-point of ``tick`` on.

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

    def define_position(self, message: PositionMessage, tick: int = 0) -> Position:
        """Solve a position equation for T6 and enter it.

        Args:
            message: the equation.
            tick: of the next set-point.

        Raises:
            EquationError: not exactly one T6, an unknown transform, a tool or compliance frame
                that is not in it, a second definition, or one too many.
        """
        name = message.name
        if name in self._positions:
            raise EquationError(f"position {name!r} is defined already; use another name")
        self._positions.check_room(name)
        words = message.configuration
        try:
            configuration = self.configuration if words is None else Configuration.parse(words)
        except KinematicsError as error:
            raise EquationError(f"position {name!r}: {error}") from error
        position = Position(name, Ring(message, self._sources(message)), configuration)
        for transform, lever in position.levers(Moment(tick)).items():
            reference = self._transforms.table[transform]
            if isinstance(reference, Reference):
                reference.lever = max(reference.lever, lever)
        self._positions[name] = position
        return position

    def define_mode(self, message: ModeMessage) -> MotionMode:
        """Enter a mode.

        Raises:
            ModeError: it contradicts itself, a second definition, or one too many.
        """
        name = message.name
        if name in self._modes:
            raise ModeError(f"mode {name!r} is defined already; use another name")
        self._modes.check_room(name)
        mode = self._modes[name] = MotionMode.from_message(message)
        return mode

    def position(self, name: str) -> Position:
        """A position by name; ``ProgramError`` lists those that exist."""
        return self._positions.look_up(name)

    def mode(self, name: str) -> MotionMode:
        """A mode by name; ``ProgramError`` lists those that exist."""
        return self._modes.look_up(name)

    def names(self) -> WorldNames:
        """What there is."""
        return WorldNames(dict(self._transforms.kinds), list(self._positions), list(self._modes))

    def _sources(self, message: PositionMessage) -> dict[str, Transform | Live]:
        """The transforms of an equation."""
        table = self._transforms.table
        sources: dict[str, Transform | Live] = {}
        for transform in (*message.left, *message.right):
            if transform == T6:
                continue
            if transform not in table:
                raise EquationError(
                    f"position {message.name!r}: transform {transform!r} is not defined; "
                    f"{table.listing()}"
                )
            sources[transform] = table[transform]
        return sources
