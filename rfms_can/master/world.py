"""The world model: symbol tables of transforms, positions and modes (thesis VI.4.1, VI.4.3)."""

from dataclasses import dataclass
from typing import TypeVar

from rfms_can.errors import EquationError, KinematicsError, ModeError, ProgramError
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import FixedGoal
from rfms_can.messages import T6, ModeMessage, PositionMessage, TransformMessage, WorldNames
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode

Entry = TypeVar("Entry")


@dataclass(frozen=True, slots=True, eq=False)
class Position:
    """A solved position equation.

    Attributes:
        name: as defined.
        goal: T6 = L D R of it.
        configuration: branch of the inverse solution.
    """

    name: str
    goal: FixedGoal
    configuration: Configuration


@dataclass(frozen=True, slots=True, eq=False)
class MotionMode:
    """How a segment is moved; times in s."""

    name: str
    mode: Mode
    segment_time: float
    acceleration_time: float


class WorldModel:
    """Transforms may be redefined; a position or a mode only once, as the thesis has it.

    Args:
        configuration: what a position takes that names none.
    """

    def __init__(self, configuration: Configuration) -> None:
        self.configuration = configuration
        self._transforms: dict[str, Transform] = {}
        self._positions: dict[str, Position] = {}
        self._modes: dict[str, MotionMode] = {}

    def names(self) -> WorldNames:
        """What the tables hold."""
        kinds = dict.fromkeys(self._transforms, "value")
        return WorldNames(kinds, list(self._positions), list(self._modes))

    def define_transform(self, message: TransformMessage) -> None:
        """Enter or replace a transform.

        Raises:
            EquationError: its rotation is none, or its name is taken by the arm.
        """
        transform = Transform(*message.rows)
        if message.name == T6:
            raise EquationError(f"transform {T6!r} is the arm itself and cannot be defined")
        if not transform.is_rigid():
            raise EquationError(
                f"transform {message.name!r} is no rotation: off by "
                f"{transform.rigidity_error():.3g}; build it with Transform.rotation and @"
            )
        self._transforms[message.name] = transform

    def define_position(self, message: PositionMessage) -> Position:
        """Solve a position equation for T6 and enter it.

        Raises:
            EquationError: not exactly one T6, an unknown transform, or a second definition.
        """
        name = message.name
        if name in self._positions:
            raise EquationError(f"position {name!r} is defined already; use another name")
        try:
            configuration = (
                self.configuration
                if message.configuration is None
                else Configuration.parse(message.configuration)
            )
        except KinematicsError as error:
            raise EquationError(f"position {name!r}: {error}") from error
        goal = self._solve(message)
        self._positions[name] = position = Position(name, goal, configuration)
        return position

    def define_mode(self, message: ModeMessage) -> None:
        """Enter a mode.

        Raises:
            ProgramError: no segment time, or a second definition.
        """
        if message.name in self._modes:
            raise ProgramError(f"mode {message.name!r} is defined already; use another name")
        if message.segment_time is None:
            raise ModeError(f"mode {message.name!r}: give a segment time")
        self._modes[message.name] = MotionMode(
            message.name,
            Mode[message.interpolation.upper()],
            message.segment_time,
            message.acceleration_time,
        )

    def position(self, name: str) -> Position:
        """A position by name; ``ProgramError`` lists those that exist."""
        return _look_up("position", name, self._positions)

    def mode(self, name: str) -> MotionMode:
        """A mode by name; ``ProgramError`` lists those that exist."""
        return _look_up("mode", name, self._modes)

    def _solve(self, message: PositionMessage) -> FixedGoal:
        """T6 = L D R: go round the ring of the equation from T6 to T6 (Fig. 6.5)."""
        name = message.name
        count = message.left.count(T6) + message.right.count(T6)
        if count != 1:
            raise EquationError(f"position {name!r}: {T6} stands {count} times; it must stand once")
        sides = (message.left, message.right)
        with_t6, other = sides if T6 in message.left else (sides[1], sides[0])
        place = with_t6.index(T6)
        before, after = with_t6[:place], with_t6[place + 1 :]
        tools = after if message.tool is None else after[:1]
        if message.tool is not None and message.tool not in tools:
            raise EquationError(
                f"position {name!r}: tool {message.tool!r} must stand right after {T6}"
            )
        left = self._product(name, before).inverse() @ self._product(name, other)
        left = left @ self._product(name, after[len(tools) :]).inverse()
        return FixedGoal(left, self._product(name, tools))

    def _product(self, position: str, names: list[str]) -> Transform:
        product = Transform.identity()
        for name in names:
            if name not in self._transforms:
                known = ", ".join(self._transforms) or "none"
                raise EquationError(
                    f"position {position!r}: transform {name!r} is not defined; there are: {known}"
                )
            product = product @ self._transforms[name]
        return product


def _look_up(kind: str, name: str, table: "dict[str, Entry]") -> "Entry":
    if name not in table:
        known = ", ".join(table) or "none"
        raise ProgramError(f"{kind} {name!r} is not defined; there are: {known}")
    return table[name]
