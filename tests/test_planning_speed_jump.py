"""A table that is not at rest at its ends is refused in words, not with an angle of -275 rad."""

import re
from collections.abc import Iterator
from itertools import count

import pytest

from rfms_can.coordinator import Arm, MoveError, Table, TableRow, Transform
from rfms_can.messages import Vector6
from rfms_can.rig.session import Session
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig

ALONG: Vector6 = (0.05, 0.0, 0.0, 0.0, 0.0, 0.0)
TURN: Vector6 = (0.0, 0.0, 0.0, 0.0, 0.3, 0.0)
REST: Vector6 = (0.0,) * 6
NUMBER = count()


@pytest.fixture(scope="module")
def arm() -> Iterator[Arm]:
    session = Session(SimulatedRig(RunSettings(friction="none")))
    session.bring_up()
    yield Arm(session.link)
    session.disable()


def moved(arm: Arm, table: Table, interpolation: str) -> None:
    """A move of 2 s that follows a table."""
    n = next(NUMBER)
    curve = arm.functional(f"curve {n}", table)
    here = arm.transform(f"here {n}", arm.pose @ Transform.translation(0.01, 0.0, -0.02))
    arm.position(f"there {n}", arm.t6 == here @ curve)
    arm.mode(
        f"slow {n}",
        segment_time=2.0,
        acceleration_time=0.2,
        interpolation="cartesian" if interpolation == "cartesian" else "joint",
    )
    arm.move(f"there {n}", f"slow {n}")


@pytest.mark.parametrize("interpolation", ["joint", "cartesian"])
@pytest.mark.parametrize("end", [ALONG, TURN])
@pytest.mark.parametrize("span", [(0.0, 1.0), (-3.0, 2.0), (1.0, 1.2)])
def test_a_table_that_ends_in_motion_is_refused_in_words(
    arm: Arm, span: tuple[float, float], end: Vector6, interpolation: str
) -> None:
    table = Table([TableRow(span[0], REST), TableRow(span[1], end)], "linear", "t")
    with pytest.raises(MoveError) as refused:
        moved(arm, table, interpolation)
    told = str(refused.value)
    assert "\n" not in told
    jumps = re.search(r"speed jumps.* near t = \S+ s, h = .*interpolation 'cubic'", told)
    reached = re.search(r"would (accelerate|run) at", told)
    assert jumps or reached, told
    assert "would reach" not in told


def test_a_table_that_is_at_rest_at_its_ends_is_followed(arm: Arm) -> None:
    table = Table([TableRow(0.0, REST), TableRow(3.0, ALONG)], "cubic", "t")
    moved(arm, table, "cartesian")
    arm.wait()
