"""The mass in a mode: added while a move has it, taken away again (thesis IV.6)."""

import math

import pytest

from rfms_can.arm import PUMA_560
from rfms_can.coordinator import Arm, Transform
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.errors import ModeError
from rfms_can.kinematics import Configuration, direct
from rfms_can.master.world import WorldModel
from rfms_can.messages import ModeMessage
from rfms_can.plant.physics import PlantPhysics
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig

MASS, REACH = 2.5, 0.15


def test_a_mode_leaves_the_load_as_it_was_unless_it_says_a_mass() -> None:
    world = WorldModel(Configuration(True, True, True), 0.004)
    assert world.define_mode(ModeMessage("bare", "joint", 0.1, 1.0)).mass is None
    assert world.define_mode(ModeMessage("held", "joint", 0.1, 1.0, mass=MASS)).mass == MASS


@pytest.mark.parametrize("mass", [-1.0, math.nan, math.inf])
def test_a_mass_that_is_none_is_refused(mass: float) -> None:
    world = WorldModel(Configuration(True, True, True), 0.004)
    with pytest.raises(ModeError, match=f"mass {mass}"):
        world.define_mode(ModeMessage("m", "joint", 0.1, 1.0, mass=mass))


@pytest.mark.system
def test_the_master_compensates_for_it_from_the_move_on_that_has_it() -> None:
    rigs: list[SimulatedRig] = []
    gained: list[float] = []

    def keep(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        rigs.append(rig)

    def gain() -> float:
        """Gravity of joint 2 in the rows, less that of the bare arm."""
        master = rigs[0].master
        bare = ArmDynamics(PUMA_560).gravity(master.arm_state.q)[1]
        return float(master.rows.newest.gravity[1] - bare)

    def program(arm: Arm) -> None:
        tool = arm.transform("tool", Transform.translation(0.0, 0.0, REACH))
        here = arm.transform("here", direct(PUMA_560, PUMA_560.park))
        up = arm.transform("up", Transform.translation(0.0, 0.0, -0.05))
        place = arm.position("place", arm.t6 @ tool == here @ tool @ up, tool=tool)
        other = arm.position("other", arm.t6 @ tool == here @ tool, tool=tool)
        bare = arm.mode("bare", segment_time=0.8, acceleration_time=0.2, mass=0.0)
        held = arm.mode("held", segment_time=0.8, acceleration_time=0.2, mass=MASS)
        for position, mode in ((place, bare), (other, held), (place, bare)):
            arm.wait(arm.move(position, mode))
            arm.sleep(0.1)
            gained.append(gain())

    outcome = execute(program, RunSettings(arm="puma560"), watch=keep)
    assert outcome.fault is None
    tip = direct(PUMA_560, PUMA_560.park) @ Transform.translation(0.0, 0.0, REACH)
    assert gained[0] == gained[2] == pytest.approx(0.0, abs=0.02)
    assert gained[1] == pytest.approx(MASS * 9.81 * math.hypot(tip.px, tip.py), rel=0.1)


@pytest.mark.system
def test_an_arm_that_knows_of_its_load_follows_better() -> None:
    """The known load in the hand; the mode says its mass, the position where it is."""

    def largest(mass: float) -> float:
        def program(arm: Arm) -> None:
            load = arm.transform("load", Transform.translation(0.10, 0.0, 0.15))
            here = arm.transform("here", direct(PUMA_560, PUMA_560.park))
            side = arm.transform("side", Transform.translation(0.0, 0.2, 0.1))
            there = arm.position("there", arm.t6 @ load == side @ here @ load, tool=load)
            back = arm.position("back", arm.t6 @ load == here @ load, tool=load)
            swift = arm.mode("swift", segment_time=0.9, acceleration_time=0.2, mass=mass)
            arm.wait(arm.move(back, swift))
            for position in (there, back, there, back):
                arm.wait(arm.move(position, swift))

        result = execute(program, RunSettings(arm="puma560", plant="nominal+load")).result
        assert result.fault is None
        return math.hypot(*(joint.moving_rms for joint in result.joints))

    assert largest(MASS) < 0.5 * largest(0.0)


def test_a_plant_without_a_load_is_as_it_was() -> None:
    bare = PlantPhysics(PUMA_560, "corke", 250.0)
    assert bare.model.engine[0].nbody == 7
