"""Modes: what they say of a segment, and how they may contradict themselves."""

import math
import re
from typing import Any, Literal

import pytest

from rfms_can.errors import ModeError
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.segment import Transition
from rfms_can.master.world import Limits, WorldModel
from rfms_can.messages import ModeMessage
from rfms_can.wire.vocabulary import Mode

OWN = Configuration(True, False, True)


def mode(**fields: Any) -> ModeMessage:
    """A mode of 2 s, with some of its fields changed."""
    every = {"interpolation": "joint", "acceleration_time": 0.2, "segment_time": 2.0, **fields}
    return ModeMessage("m", **every)


def test_a_mode_keeps_what_it_was_given() -> None:
    world = WorldModel(OWN, 0.004)
    message = ModeMessage(
        *("seam", "cartesian", 0.1, None, 0.05, 0.3, 0.4, True, 3.0, "cartesian", 2.0, 7.0),
        "right up flip",
    )
    kept = world.define_mode(message)
    assert world.mode("seam") is kept
    assert (kept.name, kept.mode, kept.transition) == ("seam", Mode.CARTESIAN, Transition.CARTESIAN)
    assert (kept.acceleration_time, kept.segment_time) == (0.1, None)
    assert (kept.speed, kept.angular_speed, kept.joint_speed) == (0.05, 0.3, 0.4)
    assert (kept.lengthen, kept.lengthen_at_most) == (True, 3.0)
    assert kept.limits == Limits(2.0, 7.0)
    assert kept.configuration == Configuration(False, True, False)


@pytest.mark.parametrize(
    ("speeds", "angular_speed"),
    [
        ({"speed": 0.1}, 0.5),
        ({"speed": 0.1, "angular_speed": 3.0}, 3.0),
        ({"speed": 0.1, "joint_speed": 0.4}, None),
        ({"joint_speed": 0.4}, None),
        ({"angular_speed": 0.3}, 0.3),
    ],
)
def test_a_rotation_has_a_speed_of_its_own(
    speeds: dict[str, float], angular_speed: float | None
) -> None:
    """30 degrees at speed=0.1 took 0.2 s: only where nothing bounds how fast the tool turns."""
    kept = WorldModel(OWN, 0.004).define_mode(mode(segment_time=None, **speeds))
    assert kept.angular_speed == (angular_speed and pytest.approx(angular_speed))


def test_what_is_not_said_of_a_mode() -> None:
    kept = WorldModel(OWN, 0.004).define_mode(mode())
    assert (kept.mode, kept.transition) == (Mode.JOINT, Transition.JOINT)
    assert kept.segment_time == 2.0
    assert (kept.speed, kept.angular_speed, kept.joint_speed) == (None, None, None)
    assert not kept.lengthen
    assert kept.limits == Limits(1.0, 5.0)
    assert kept.deviation is None
    assert kept.configuration is None


@pytest.mark.parametrize("interpolation", ["joint", "cartesian"])
def test_a_transition_in_space_leads_into_either_mode(
    interpolation: Literal["joint", "cartesian"],
) -> None:
    message = mode(interpolation=interpolation, transition="cartesian", deviation=0.002)
    kept = WorldModel(OWN, 0.004).define_mode(message)
    assert (kept.mode.name.lower(), kept.transition) == (interpolation, Transition.CARTESIAN)
    assert kept.deviation == 0.002


@pytest.mark.parametrize("speed", ["speed", "angular_speed", "joint_speed"])
def test_one_speed_is_enough(speed: str) -> None:
    message = mode(segment_time=None, **{speed: 0.5})
    assert getattr(WorldModel(OWN, 0.004).define_mode(message), speed) == 0.5


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"segment_time": None}, "give a segment time or a speed"),
        ({"speed": 0.1}, "a segment time of 2 s and speed contradict one another"),
        (
            {"angular_speed": 0.1, "joint_speed": 0.5},
            "a segment time of 2 s and angular_speed and joint_speed contradict one another",
        ),
        ({"deviation": -0.001}, "deviation -0.001 m must be more than 0 and at most 1 m; to pass"),
        ({"deviation": 0.0}, "deviation 0.0 m must be more than 0"),
        ({"deviation": 1.5}, "deviation 1.5 m must be more than 0 and at most 1 m"),
        ({"deviation": math.nan}, "deviation nan m must be more than 0"),
        ({"configuration": "left up sideways"}, "sideways"),
        ({"configuration": ""}, ""),
        ({"segment_time": math.nan}, "segment_time nan must be a number more than zero"),
        ({"acceleration_time": math.inf}, "acceleration_time inf must be a number"),
        ({"acceleration_time": 0.0}, "acceleration_time 0.0 must be a number"),
        ({"segment_time": None, "speed": -1.0}, "speed -1.0 must be a number"),
        ({"acceleration": math.nan}, "acceleration nan must be a number"),
        ({"angular_acceleration": 0.0}, "angular_acceleration 0.0 must be a number"),
        ({"mass": math.nan}, "mass nan must be a number, zero or more"),
        ({"mass_centre": (0.0, 0.0, 0.1)}, "a mass_centre (0.0, 0.0, 0.1) without a mass: give"),
        ({"mass": 1.0, "mass_centre": (math.nan, 0.0, 0.0)}, "nan m is not within 2 m of the hand"),
        (
            {"mass": 1.0, "mass_centre": (0.0, 0.0, 1e6)},
            "1000000.0 m is not within 2 m of the hand",
        ),
    ],
)
def test_modes_that_say_nothing_or_too_much(fields: dict[str, Any], reason: str) -> None:
    world = WorldModel(OWN, 0.004)
    with pytest.raises(ModeError, match=f"mode 'm': .*{re.escape(reason)}"):
        world.define_mode(mode(**fields))
    assert world.names().modes == []
