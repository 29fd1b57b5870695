"""Definitions and requests of a program as messages: built and checked before they are sent.

Both variants of the program API, :class:`Arm` and :class:`AsyncArm`, build their messages here. The
checks are those of the message types, so an error is reported with the line of the program; the
server repeats them and adds those that need the world model.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

from rfms_can.compliance.selection import Selection, SelectionError, parse_bias
from rfms_can.coordinator.equation import Equation, Expression
from rfms_can.coordinator.mode_settings import ModeSettings
from rfms_can.coordinator.validation import checked
from rfms_can.errors import (
    EquationError,
    JointPositionError,
    ModeError,
    MoveError,
    ProgramError,
    TransformError,
)
from rfms_can.messages import (
    FARTHEST_CORNER,
    T6,
    AnyFunction,
    ComplyRequest,
    FeedRequest,
    GrantRequest,
    GripperRequest,
    JointPositionMessage,
    LockRequest,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    RemoveRequest,
    TransformMessage,
    Vector6,
)
from rfms_can.messages.world import Predict, What
from rfms_can.transform import Transform

IDENTITY: Final = Transform.identity()
TARE_S: Final = 0.6
"""Longest duration of a tare, s."""
REST_AFTER_S: Final = 0.2
"""Time in which a reference comes to rest once observations stay out, unless it is given, s."""

LOOK_S: Final = 0.05
"""Time between two looks whether a sensor is there, s."""
LONGEST_WAIT_S: Final = 3600.0
"""Longest wait for a sensor, s."""


def value(name: str, pose: Transform) -> TransformMessage:
    """A transform of kind value.

    Raises:
        TransformError: it is not a transform, or the name is empty or too long.
    """
    return _transform(TransformMessage(name, _pose(name, pose)))


def reference(name: str, pose: Transform, predict: Predict, rest_after: float) -> TransformMessage:
    """A transform of kind reference; raises as :func:`value` does."""
    message = TransformMessage(
        name, _pose(name, pose), kind="reference", predict=predict, rest_after=rest_after
    )
    return _transform(message)


def functional(name: str, function: AnyFunction, base: Transform) -> TransformMessage:
    """A transform of kind functional: ``base`` times the function.

    Raises:
        TransformError: it is not a function, or one of its values is not a number.
    """
    if not isinstance(function, AnyFunction):
        raise TransformError(
            f"transform {name!r}: {function!r} is not a Linear, Circular, Weave or Table; the "
            f"server evaluates the function, so it cannot be Python code"
        )
    return _transform(
        TransformMessage(name, _pose(name, base), kind="functional", function=function)
    )


def observation(
    of: str | Expression,
    pose: Transform,
    at: float | None,
    twist: Vector6 | None,
    references: Mapping[str, Predict],
) -> TransformMessage:
    """An observation of a reference.

    Args:
        of: its name, or the expression returned by its definition.
        pose: observed value.
        at: the server's time of the observation, s; None: now.
        twist: observed velocity and angular velocity, m/s and rad/s; None: estimated.
        references: the program's references and their prediction.

    Raises:
        TransformError: not a reference of this program, or the value is not a transform.
    """
    name = str(of)
    predict = references.get(name)
    if predict is None:
        raise TransformError(
            f"transform {name!r} is not a reference of this program; only these can be observed: "
            f"{', '.join(references) or 'none'}; define it with reference()"
        )
    message = TransformMessage(
        name, _pose(name, pose), kind="reference", predict=predict, twist=twist, stamp=at
    )
    return _transform(message)


def sighting(
    name: str,
    pose: Transform,
    at: float | None,
    twist: Sequence[float] | None,
    *,
    predict: Predict | None,
    rest_after: float | None,
) -> TransformMessage:
    """An observation by a sensor, which does not know the coordinator's references.

    Raises:
        TransformError: the value is not a transform, or a number is out of bounds.
    """
    exact: Vector6 | None = None if twist is None else tuple(twist)  # type: ignore[assignment]
    return _transform(
        TransformMessage(
            name,
            _pose(name, pose),
            kind="reference",
            predict=predict,
            twist=exact,
            stamp=at,
            rest_after=rest_after,
        )
    )


def grant(sensor: str, references: Sequence[str | Expression]) -> GrantRequest:
    """What a sensor may observe; ``ProgramError`` if a name is invalid, or they are too many."""
    if isinstance(references, str):
        raise ProgramError(
            f"grant to sensor {sensor!r}: references {references!r} is one text; give a list of "
            f"names, as in [{references!r}]"
        )
    return checked(
        GrantRequest(sensor, [str(reference) for reference in references]),
        ProgramError,
        f"grant to sensor {sensor!r}",
    )


def patience(sensor: str, within: float) -> float:
    """How long to wait for a sensor, s; ``ProgramError`` if it is not 0 to an hour."""
    if not isinstance(within, float | int) or not 0.0 <= within <= LONGEST_WAIT_S:  # also NaN
        raise ProgramError(
            f"grant to sensor {sensor!r}: within {within!r} s, 0 to {LONGEST_WAIT_S:g} may be"
        )
    return within


def absent(sensor: str, within: float, sensors: Mapping[str, str]) -> ProgramError:
    """The error for a sensor that did not connect."""
    return ProgramError(
        f"sensor {sensor!r} has not connected within {within:g} s (it is "
        f"{sensors.get(sensor, 'not granted')}): start its program, with connect_sensor"
    )


def position(
    name: str,
    equation: Equation,
    tool: Expression | None,
    compliance: Expression | None,
    config: str | None,
) -> PositionMessage:
    """A position by its equation.

    Raises:
        EquationError: not an equation that contains T6 once, or tool or compliance frame are not
            one transform each.
    """
    if not isinstance(equation, Equation):
        raise EquationError(f"position {name!r}: give an equation like t6 @ tool == part")
    times = (*equation.left, *equation.right).count(T6)
    if times != 1:
        raise EquationError(
            f"position {name!r}: {T6} occurs {times} times in {equation!r}; it must occur once, "
            f"as in t6 @ tool == part"
        )
    message = PositionMessage(
        name,
        list(equation.left),
        list(equation.right),
        _single(name, "tool", tool),
        _single(name, "compliance", compliance),
        config,
    )
    return checked(message, EquationError, f"position {name!r}")


def joint_position(name: str, angles: Sequence[float]) -> JointPositionMessage:
    """A position by joint angles, rad (6).

    Raises:
        JointPositionError: they are not six finite numbers, or the name is empty or too long.
    """
    what = f"position {name!r}"
    given = JointPositionMessage(name, angles)  # type: ignore[arg-type]
    try:
        message = checked(given, JointPositionError, what)
    except JointPositionError as error:
        raise JointPositionError(
            f"{error}; give six joint angles in rad, as in arm.joints"
        ) from error
    for joint, angle in enumerate(message.angles, 1):
        if not math.isfinite(angle):
            raise JointPositionError(
                f"{what}: joint {joint} at {angle} rad: give a finite angle inside its range"
            )
    return message


def mode(name: str, settings: ModeSettings) -> ModeMessage:
    """A mode.

    Raises:
        ModeError: a setting that does not exist, is missing, or is out of bounds.
    """
    given: dict[str, Any] = {"interpolation": "joint", **settings}
    configuration = given.pop("config", None)
    deviation = given.get("deviation")
    if isinstance(deviation, float | int) and not 0.0 < deviation <= FARTHEST_CORNER:  # also NaN
        raise ModeError(
            f"mode {name!r}: deviation {deviation} m must be more than 0 and at most "
            f"{FARTHEST_CORNER:g} m; to pass through the position itself, wait for the move to it"
        )
    try:
        message = ModeMessage(name, configuration=configuration, **given)
    except TypeError as error:
        raise ModeError(f"mode {name!r}: {error}; see ModeSettings") from error
    return checked(message, ModeError, f"mode {name!r}")


def remove(name: str | Expression, what: What | None) -> RemoveRequest:
    """A name to remove; an expression is that of a transform.

    Raises:
        ProgramError: not a name, or an expression of several transforms.
    """
    if isinstance(name, Expression):
        if len(name.names) != 1 or what not in (None, "transform"):
            raise ProgramError(
                f"remove {name!r}: give one transform, as returned by arm.transform(), or the name "
                f"of a position or mode"
            )
        name, what = name.names[0], "transform"
    return checked(RemoveRequest(name, what), ProgramError, f"remove {name!r}")


def move(to: str, with_mode: str) -> MoveRequest:
    """A move; ``MoveError`` if a name is invalid."""
    return checked(MoveRequest(to, with_mode), MoveError, f"move to {to!r} with {with_mode!r}")


def gripper(opens: bool, force: float) -> GripperRequest:
    """A gripper command.

    Raises:
        ProgramError: the force is not a fraction.
    """
    if isinstance(force, float | int) and not 0.0 < force <= 1.0:
        raise ProgramError(f"gripper force {force} is outside 0..1 (a fraction of the full force)")
    return checked(GripperRequest(opens, force), ProgramError, "gripper")


def feed(rate: float) -> FeedRequest:
    """A feed rate; ``ProgramError`` if it is out of bounds."""
    return checked(FeedRequest(rate), ProgramError, f"feed rate {rate}")


def comply(word: str, values: tuple[float, ...]) -> ComplyRequest:
    """Directions to comply in, with their bias forces; ``SelectionError`` as the server raises."""
    request = checked(ComplyRequest(word, list(values)), SelectionError, f"comply {word!r}")
    parse_bias(word, values)
    return request


def lock(word: str) -> LockRequest:
    """Directions to stop complying in; ``SelectionError`` as the server raises."""
    request = checked(LockRequest(word), SelectionError, f"lock {word!r}")
    Selection.parse(word)
    return request


def _transform(message: TransformMessage) -> TransformMessage:
    return checked(message, TransformError, f"transform {message.name!r}")


def _pose(name: str, pose: Transform) -> Transform:
    if not isinstance(pose, Transform):
        raise TransformError(f"transform {name!r}: a Transform is needed, not {pose!r}")
    return pose


def _single(name: str, what: str, expression: Expression | None) -> str | None:
    """The name of the one transform that is tool or compliance frame."""
    if expression is None:
        return None
    if not isinstance(expression, Expression) or len(expression.names) != 1:
        default = f"everything right of {T6}" if what == "tool" else "the tool's frame"
        raise EquationError(
            f"position {name!r}: {what} {expression!r} must be one transform, as returned by "
            f"arm.transform(); the default is {default}"
        )
    return expression.names[0]
