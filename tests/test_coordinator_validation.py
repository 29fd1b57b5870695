"""What a program is told of a number it got wrong: the field, its value, and what was expected."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from rfms_can.coordinator import definitions
from rfms_can.errors import ModeError, ProgramError
from rfms_can.messages import ModeMessage
from rfms_can.transform import Transform


def mode(**more: Any) -> Callable[[], object]:
    settings: Any = {"segment_time": 1.0, "acceleration_time": 0.1, **more}
    return lambda: definitions.mode("m", settings)


@pytest.mark.parametrize(
    ("ask", "complaint"),
    [
        (mode(mass=-1.0), r"mode 'm': mass -1.0: expected `float` >= 0.0"),
        (
            mode(mass=1.0, mass_centre=(0.0, "a", 0.0)),
            r"mass_centre\[1\] 'a': expected `float`, got `str`",
        ),
        (mode(comply={"fx": "b"}), r"comply\[...\] {'fx': 'b'}: expected `float`, got `str`"),
        (mode(stop_on_force={3: 1.0}), r"stop_on_force {3: 1.0}: expected `str`, got `int`"),
        (mode(interpolation="bent"), r"interpolation 'bent': invalid enum value"),
        (lambda: definitions.comply("fx", ("a",)), r"comply 'fx': values\[0\] 'a': expected"),  # type: ignore[arg-type]
        (lambda: definitions.comply(None, ()), r"comply None: word None: expected `str`"),  # type: ignore[arg-type]
        (
            lambda: definitions.comply("fx", (object(),)),  # type: ignore[arg-type]
            r"comply 'fx': <object .*> is not a number",
        ),
        (lambda: definitions.gripper(True, "all"), r"gripper: part 'all': expected `float`"),  # type: ignore[arg-type]
        (lambda: definitions.lock(3), r"lock 3: word 3: expected `str`, got `int`"),  # type: ignore[arg-type]
        (lambda: definitions.feed(1.5), r"feed rate 1.5: .*<= 1.0"),
    ],
)
def test_a_value_of_a_wrong_kind_or_size_is_named(
    ask: Callable[[], object], complaint: str
) -> None:
    with pytest.raises(ProgramError, match=complaint):
        ask()


def test_numbers_of_numpy_are_numbers() -> None:
    assert definitions.comply("fz", (np.float64(3.0),)).values == [3.0]
    centre = mode(mass=1.0, mass_centre=np.array([0.0, 0.0, 0.1]))()
    assert isinstance(centre, ModeMessage) and centre.mass_centre == (0.0, 0.0, 0.1)
    assert definitions.feed(np.float32(0.5)).rate == 0.5  # type: ignore[arg-type]
    at = definitions.value("p", Transform.translation(*np.array([0.1, 0.2, 0.3])))
    assert at.rows == tuple(Transform.translation(0.1, 0.2, 0.3))


def test_the_class_of_the_error_is_the_callers() -> None:
    with pytest.raises(ModeError):
        mode(mass="heavy")()
