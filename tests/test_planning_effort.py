"""In real time planning does not keep the next cycle waiting."""

import math
import re

import numpy as np
import pytest
from support.planning import How, PlannedRig, at_angles, at_pose
from support.trajectory import REST, TAU

from rfms_can.arm import PUMA_260
from rfms_can.errors import MoveError
from rfms_can.kinematics import direct
from rfms_can.master.settings import MasterSettings
from rfms_can.master.trajectory.planning import MovePlanner
from rfms_can.master.trajectory.planning.effort import TooLongError
from rfms_can.master.trajectory.segment import Transition
from rfms_can.transform import Transform
from rfms_can.wire.configuration import Clock
from rfms_can.wire.vocabulary import Mode

FAR = at_angles((-0.9, 1.0, -2.2, 0.9, 0.6, 0.4))
TIGHT = How(Mode.CARTESIAN, 0.05, 0.2)


def rig_with(most: float) -> PlannedRig:
    rig = PlannedRig()
    rig.planner = MovePlanner(PUMA_260, TAU, most)
    rig.planner.reset(REST)
    return rig


def test_clocks_that_wait_have_all_the_time_there_is() -> None:
    assert MasterSettings(clock=Clock.VIRTUAL).effort == math.inf
    assert MasterSettings(clock=Clock.LOCKSTEP).effort == math.inf
    assert MasterSettings(clock=Clock.REALTIME, rate_hz=250.0).effort == pytest.approx(1000.0)


def test_an_ordinary_move_has_room_in_real_time_at_250_hz() -> None:
    most = MasterSettings(clock=Clock.REALTIME, rate_hz=250.0).effort
    for mode in Mode:
        rig = rig_with(most)
        plan = rig.plan(FAR, How(mode, 0.2, 1.5, lengthen=True))
        free = PlannedRig().plan(FAR, How(mode, 0.2, 1.5, lengthen=True))
        assert plan[1:] == free[1:]


def test_what_would_do_is_not_looked_for_when_the_effort_is_spent() -> None:
    enough = PlannedRig()
    with pytest.raises(MoveError) as whole:
        enough.plan(FAR, TIGHT)
    assert whole.value.remedy
    with pytest.raises(MoveError) as short:
        rig_with(400.0).plan(FAR, TIGHT)
    assert not short.value.remedy
    assert str(short.value).endswith(
        "what would do was not looked for, since in real time the next cycle does not wait: ask "
        "for it on another clock"
    )


def test_a_move_that_takes_too_long_to_plan_is_refused_and_nothing_is_remembered() -> None:
    rig = rig_with(110.0)
    reason = "takes more than 110 poses, and in real time the next cycle does not wait"
    with pytest.raises(TooLongError, match=re.escape(reason)):
        rig.plan(FAR, TIGHT)
    rig.planner.effort.begin()
    still = at_pose(direct(PUMA_260, REST) @ Transform.translation(0.0, 0.0, 0.1))
    rig.planner.plan(rig.generator.entry, still, How(Mode.JOINT, 0.05, 0.2), 1)


def test_a_path_that_is_run_costs_nothing() -> None:
    """The lines of joints in Cartesian transitions are solved in every cycle."""
    rig = rig_with(2000.0)
    how = How(Mode.JOINT, 0.2, 2.0, transition=Transition.CARTESIAN)
    rig.go(at_angles((0.4, 1.1, -2.5, 0.5, 0.8, 0.1)), how)
    rig.planner.effort.begin()
    rig.go(at_angles((0.1, 1.2, -2.6, 0.4, 0.9, 0.0)), how)
    rig.finish()
    rig.run(2000)
    assert np.isfinite(rig.q).all()
