"""Every law puts pegs into the same five misaligned holes: thesis friction, open loop, same gains.

These are the first five of the hundred of ``docs/peg-campaign.md``.
"""

from functools import cache
from pathlib import Path
from statistics import fmean

import pytest

from rfms_can.analysis.campaign.insertion import insert
from rfms_can.analysis.campaign.job import TASKS, Insertion, Job, groups_of
from rfms_can.compliance import ControlLaw

pytestmark = pytest.mark.system

PROGRAM = Path(__file__).parents[1] / "examples" / "peg_in_hole.py"
SEEDS = range(5)
DITHER = 0.9
LEANT_ON = 80.0
"""Side force, N, that position control exceeds."""


@cache
def pegs(law: ControlLaw) -> list[Insertion]:
    """The five."""
    (group,) = groups_of(TASKS[:1], ("thesis",), [law])
    return [insert(Job(group, seed, DITHER), PROGRAM) for seed in SEEDS]


def lateral(law: ControlLaw) -> float:
    """Mean of the lateral peaks, N."""
    return fmean(peg.lateral_peak for peg in pegs(law))


@pytest.mark.parametrize(
    "law",
    [ControlLaw.WEIGHTED, ControlLaw.HYBRID, ControlLaw.RAIBERT_CRAIG, ControlLaw.STIFFNESS],
)
def test_what_complies_goes_in_with_half_the_side_force_of_position_control(
    law: ControlLaw,
) -> None:
    print(f"{law.value}: {lateral(law):.1f} N, position: {lateral(ControlLaw.POSITION):.1f} N")
    assert [peg.why for peg in pegs(law)] == [""] * len(SEEDS)
    assert all(peg.inserted for peg in pegs(law))
    assert lateral(law) < 0.5 * lateral(ControlLaw.POSITION)


def test_position_control_leans_on_the_wall() -> None:
    found = pegs(ControlLaw.POSITION)
    print([f"{peg.lateral_peak:.0f} N" for peg in found])
    assert max(peg.lateral_peak for peg in found) > LEANT_ON


def test_free_joints_put_it_in_at_some_places_and_jam_at_others() -> None:
    """With joint 3 free the arm pushes towards its elbow only: one side of the chamfer holds that.

    Where it jams, the arm is halted or the program gives up, and says why.
    """
    found = pegs(ControlLaw.FREE_JOINT)
    into = [peg.inserted for peg in found]
    print(into, [peg.why for peg in found])
    assert 0 < sum(into) < len(found)
    assert all(bool(peg.why) != peg.inserted for peg in found)
