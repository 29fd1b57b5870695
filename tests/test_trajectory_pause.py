"""A pause whose ramp is still under way when the start of a moving goal would be looked at."""

from support.programs.random_moves import Leg
from test_trajectory_properties import Pace, run

from rfms_can.master.trajectory.segment import Transition
from rfms_can.wire.vocabulary import Mode


def legs() -> list[Leg]:
    joint = (Mode.JOINT, Transition.JOINT)
    return [
        Leg((0.499, 1.1, -2.525, 0.118, 1.3, -0.158), "weaving", *joint, 0.47, 0.2, 0.46),
        Leg((0.0, 1.0, -2.843, 0.285, 0.899, -0.414), "moving", *joint, 0.55, 0.21, 0.22),
    ]


def test_the_look_ahead_at_a_moving_goal_waits_for_the_ramp_of_a_pause() -> None:
    """Its pace is kept until the hand-over: kept at nothing, the arm would never arrive."""
    for first in range(40, 90, 4):
        changes = [Pace(first / 100, 0.0, 0.12), Pace(0.54, 0.25, 0.13), Pace(0.4, 0.25, 0.34)]
        rig = run(legs(), changes)
        assert rig.generator.completed == 2
