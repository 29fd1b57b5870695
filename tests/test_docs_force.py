"""docs/force.md: its numbers are the code's."""

from pathlib import Path

import pytest

from rfms_can.compliance import ControlLaw
from rfms_can.joint_nodes import friction, servo
from rfms_can.master.force import bias, comply, control, wrench_estimate
from rfms_can.master.rows.math_processor import COMPLIANT_DAMPING
from rfms_can.master.start_up.node_parameters import DITHER_PERIODS_S

PAGE = " ".join((Path(__file__).parents[1] / "docs" / "force.md").read_text("utf-8").split())


@pytest.mark.parametrize(
    "words",
    [
        f"μ = {COMPLIANT_DAMPING:g} 1/s",
        f"1/μ = {1e3 / COMPLIANT_DAMPING:.0f} ms",
        f"Beyond {comply.MAX_DISPLACEMENT:g} m or {comply.MAX_ROTATION:g} rad",
        f"at most {bias.BIAS_FRACTION:g} of a torque limit",
        f"at most {100 * bias.SLEW_FRACTION:g} % of it a cycle",
        f"f + {bias.PROPORTIONAL:g} e + {bias.INTEGRAL_RATE:g} ∫e dt",
        f"stops at {bias.INTEGRAL_LIMIT[0]:g} N or {bias.INTEGRAL_LIMIT[5]:g} N m",
        f"below {bias.CONTACT[0]:g} N and {bias.CONTACT[3]:g} N m felt, the loop is open",
        f"goes within {bias.MOVING_FADE_S:g} s once it is faster than "
        f"{1e3 * bias.MOVING[0]:g} mm/s or {bias.MOVING[3]:g} rad/s",
        f"it fades with a time constant of {bias.INTEGRAL_FADE_S:g} s",
        f"an error within {bias.DEAD_BAND[0]:g} N and {bias.DEAD_BAND[3]:g} N m",
        f"the mean of {wrench_estimate.TARE_CYCLES} readings",
        f"beyond {friction.MOVING_CODES:g} ADC codes",
        f"{100 * friction.COMPLYING_FRACTION:g} % of the Coulomb part",
        f"every {1e3 * min(DITHER_PERIODS_S):g} to {1e3 * max(DITHER_PERIODS_S):g} ms",
        f"may use {servo.COMPLYING_INTEGRAL_FRACTION:g} of what",
        f"at most {100 * friction.TRANSFER_FRACTION:g} % of its limit a cycle",
    ],
)
def test_a_number_is_the_codes(words: str) -> None:
    assert words in PAGE


def test_the_way_back_takes_a_fifth_of_the_joints_limits() -> None:
    assert pytest.approx(0.2) == control.FADE_FRACTION
    assert "within a fifth of each joint's speed and acceleration limits" in PAGE


def test_every_law_stands_in_the_table() -> None:
    for law in ControlLaw:
        assert f"| `{law.value}`" in PAGE
