"""The peg in the hole over the simulated bus: thesis friction, misaligned holes, and none.

What other laws come to: ``test_force_laws.py``.
"""

from typing import Any

import pytest
from example_run import example
from support.system import across, run

from rfms_can.coordinator import ProgramError
from rfms_can.rig.runner import execute
from rfms_can.rig.settings import RunSettings

pytestmark = pytest.mark.system

HOLE = "peg:x_mm=1,tilt_x_deg=0.5"
WORSE = (
    "peg:x_mm=2,y_mm=-1,tilt_y_deg=1",
    "peg:x_mm=-1.663,y_mm=-1.018,tilt_x_deg=0.226,tilt_y_deg=-0.846",
)
LEANT_ON = 80.0
"""Side force, N, that pure position control exceeds (``test_force_laws.py``)."""


def inserted(scene: str, **settings: Any) -> tuple[float, float]:
    """Depth, m, and the largest side force, N, of a run that has ended well."""
    moments = run(example("peg_in_hole").program, scene, dither=0.9, **settings)
    depth, peak = -min(m.truth.tip.pz for m in moments), across(moments).max()
    print(f"{scene} {settings}: {1e3 * depth:.1f} mm deep, {peak:.1f} N across at most")
    return depth, peak


@pytest.mark.parametrize("scene", [HOLE, *WORSE])
def test_a_misaligned_peg_goes_in_and_out(scene: str) -> None:
    depth, peak = inserted(scene, sensor="good")
    assert depth > 0.039
    assert peak < 0.5 * LEANT_ON


def test_it_does_without_a_sensor() -> None:
    depth, peak = inserted(HOLE)
    assert depth > 0.039
    assert peak < 0.5 * LEANT_ON


def test_beside_the_hole_the_program_gives_up_and_says_how_deep() -> None:
    settings = RunSettings(
        arm="puma560", scene="peg:x_mm=5,y_mm=-4", friction="thesis", dither=0.9, sensor="good"
    )
    with pytest.raises(ProgramError, match=r"the peg is -?\d\.\d of 40 mm deep"):
        execute(example("peg_in_hole").program, settings)
