"""Random programs: whatever is asked, the arm moves evenly and ends where it was told."""

import itertools
from typing import NamedTuple

from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx
from support.programs.random_moves import angles_near, is_runnable
from support.trajectory import LEFT_DOWN, TAU, Rig

from rfms_can.arm import PUMA_260
from rfms_can.errors import MoveError
from rfms_can.kinematics import Joints, direct
from rfms_can.master.trajectory.goal import FixedGoal
from rfms_can.master.trajectory.segment import Move
from rfms_can.wire.vocabulary import Blend, Mode

REST = (0.2, 1.2, -2.9, 0.3, 1.0, -0.2)


class Leg(NamedTuple):
    """A move of a random program; ``pause`` is the ticks between its request and the next."""

    q: Joints
    mode: Mode
    segment_ticks: int
    acceleration_ticks: int
    pause: int


legs = st.builds(
    Leg,
    q=angles_near(REST, (0.4, 0.3, 0.3, 0.5, 0.4, 0.5)),
    mode=st.sampled_from(Mode),
    segment_ticks=st.integers(120, 300),
    acceleration_ticks=st.integers(15, 50),
    pause=st.integers(0, 250),
)


def run(program: list[Leg], blend: Blend) -> tuple[Rig, list[Leg]]:
    """Run ``program`` as far as it is taken; the rig, and the legs that were."""
    rig = Rig(blend, TAU, REST)
    taken: list[Leg] = []
    for number, leg in enumerate(program, 1):
        goal = FixedGoal(direct(PUMA_260, leg.q))
        move = Move(number, goal, leg.mode, leg.segment_ticks, leg.acceleration_ticks, LEFT_DOWN)
        before = taken[-1].q if taken else REST
        stay = Move(0, FixedGoal(direct(PUMA_260, before)), Mode.JOINT, 1, 1, LEFT_DOWN)
        if not is_runnable(stay, move, REST, TAU):
            continue
        try:
            rig.generator.request(move)
        except MoveError:
            continue
        taken.append(leg)
        rig.run(leg.pause)
    rig.finish()
    return rig, taken


@settings(max_examples=40)
@given(st.lists(legs, min_size=1, max_size=4), st.sampled_from(Blend))
def test_random_programs_run_evenly_to_their_ends(program: list[Leg], blend: Blend) -> None:
    rig, taken = run(program, blend)
    if not taken:
        return
    assert rig.generator.completed == rig.setpoints[-1].sequence
    assert rig.q[-1] == approx(taken[-1].q, abs=1e-9)
    steps = [
        max(abs(a - b) for a, b in zip(before, now, strict=True))
        for before, now in itertools.pairwise(rig.q)
    ]
    for before, now, after in zip(steps, steps[1:], steps[2:], strict=False):
        assert now > 0.0 or before < 1e-6 or after < 1e-6, "a set-point was sent twice in motion"
    # Blending out the largest change of velocity, from one full speed to the other, takes under
    # twice the speed over t_acc; a set-point sent twice would be a step of the whole speed.
    shortest = min(leg.acceleration_ticks for leg in taken)
    assert rig.difference(2) * TAU <= 2.0 * rig.difference(1) / shortest + 1e-9
