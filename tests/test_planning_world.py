"""Positions and modes of the world model, planned and run: what a program's request becomes."""

from typing import Any

import pytest
from pytest import approx
from support.planning import TOOL, PlannedRig
from support.trajectory import REST

from rfms_can.arm import PUMA_260
from rfms_can.errors import MoveError
from rfms_can.kinematics import direct
from rfms_can.master.trajectory.planning import Plan
from rfms_can.master.world import WorldModel
from rfms_can.messages import Linear, ModeMessage, PositionMessage, TransformMessage
from rfms_can.transform import Transform

START = direct(PUMA_260, REST) @ TOOL


class Server(PlannedRig):
    """A planned rig with a world model, and tool E."""

    def __init__(self) -> None:
        super().__init__()
        self.world = WorldModel(self.generator.last_accepted.move.configuration, self.period_s)
        self.transform("e", TOOL)

    def transform(self, name: str, value: Transform, **more: Any) -> None:
        message = TransformMessage(name, value[:], **more)
        self.world.define_transform(message, self.generator.tick_count)

    def position(self, name: str, *right: str) -> None:
        message = PositionMessage(name, ["t6", "e"], list(right), tool="e")
        self.world.define_position(message)

    def request(self, position: str, **mode: Any) -> Plan:
        name = f"mode{len(self.world.names().modes)}"
        self.world.define_mode(ModeMessage(name, **mode))
        return self.go(self.world.position(position), self.world.mode(name))


def test_speeds_of_a_mode_become_the_time_of_a_move() -> None:
    server = Server()
    server.transform("b", Transform.translation(-0.05, 0.0, 0.0) @ START)
    server.position("there", "b")
    straight = {"interpolation": "cartesian", "acceleration_time": 0.2}
    assert server.request("there", speed=0.05, **straight).segment_time == approx(1.0)


def test_a_goal_that_moves_is_planned_where_it_is_and_functions_over_their_course() -> None:
    """A reference 0.1 m further off doubles the way; a function of h adds what it has at h = 1."""
    server = Server()
    server.transform("b", Transform.translation(-0.05, 0.0, 0.0) @ START, kind="reference")
    across = Linear(along=(0.0, 0.0, 0.02))
    server.transform("f", Transform.identity(), kind="functional", function=across)
    server.position("there", "b")
    server.position("above", "b", "f")
    slow: dict[str, Any] = {"interpolation": "cartesian", "acceleration_time": 0.1, "speed": 0.05}
    plain = server.plan(server.world.position("there"), mode(server, **slow))
    assert plain.segment_time == approx(1.0)
    above = server.plan(server.world.position("above"), mode(server, **slow))
    assert above.peak_speeds != approx(plain.peak_speeds, rel=0.05)
    server.transform("b", Transform.translation(-0.1, 0.0, 0.0) @ START, kind="reference")
    further = server.plan(server.world.position("there"), mode(server, **slow))
    assert further.segment_time == approx(2.0)


def mode(server: Server, **words: Any) -> Any:
    name = f"mode{len(server.world.names().modes)}"
    server.world.define_mode(ModeMessage(name, **words))
    return server.world.mode(name)


def test_a_planned_approach_of_a_reference_runs_as_planned() -> None:
    server = Server()
    server.transform("b", Transform.translation(-0.05, 0.02, 0.0) @ START, kind="reference")
    server.position("there", "b")
    server.run(12)
    for transition in ("joint", "cartesian"):
        back = {"interpolation": "cartesian", "acceleration_time": 0.1, "transition": transition}
        plan = server.request("there", segment_time=0.8, **back)
        first = len(server.q) - 3
        server.finish()
        speeds, accelerations = server.peaks(first)
        assert speeds == approx(plan.peak_speeds, rel=0.03)
        assert accelerations == approx(plan.peak_accelerations, rel=0.03)
        server.transform("home", START)
        server.position(f"home{transition}", "home")
        server.request(f"home{transition}", segment_time=0.8, **back)
        server.finish()


def test_a_mode_too_fast_is_refused_by_name_of_the_joint() -> None:
    server = Server()
    turned = START @ Transform.rotation((0.0, 0.0, 1.0), 1.5)
    server.transform("b", turned)
    server.position("there", "b")
    with pytest.raises(MoveError, match="joint 6 of puma260 would accelerate"):
        server.request(
            "there", interpolation="cartesian", acceleration_time=0.02, angular_speed=4.0
        )
