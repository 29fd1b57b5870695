"""The whole turn of an angle: where a range has several, the one nearest to the joint."""

import math

import pytest

from rfms_can.kinematics.limits import nearest_turn


@pytest.mark.parametrize("turns", [-3, -1, 1, 3])
def test_the_nearest_turn_is_taken_where_the_range_has_several(turns: int) -> None:
    there = 0.3 + turns * math.tau
    assert nearest_turn(0.3, there + 0.2, -21.0, 21.0) == pytest.approx(there, abs=1e-12)
    assert nearest_turn(0.3, there - 0.2, -21.0, 21.0) == pytest.approx(there, abs=1e-12)
