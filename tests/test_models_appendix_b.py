"""Appendix B as corrected, against the full model of arms whose links are as it assumes."""

from dataclasses import replace

import pytest

from rfms_can.arm import ARMS, Arm, Link
from rfms_can.dynamics.appendix_b import appendix_b
from rfms_can.dynamics.fitted import fitted_constants
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.dynamics.terms import CONSTANTS, COUPLING, GRAVITY


def as_assumed(arm: Arm) -> Arm:
    """Centres of mass on the axes of B.1 and B.2; a wrist that is heavy enough to matter."""
    one, two, three, four, five, six = arm.links
    links: tuple[Link, ...] = (
        one,
        replace(two, com=(two.com[0], 0.0, two.com[2])),
        replace(three, com=(0.0, 0.0, three.com[2])),
        four,
        replace(five, com=(0.0, 0.0, 0.01)),
        replace(six, com=(0.0, 0.0, 0.05), mass=3.0 * six.mass),
    )
    return replace(arm, links=links)


@pytest.mark.parametrize("arm", ARMS.values(), ids=list(ARMS))
def test_appendix_b_is_the_full_model(arm: Arm) -> None:
    """Gravity exactly; inertia up to the wrist's own terms, which it neglects."""
    thesis = as_assumed(arm)
    ours, full = appendix_b(thesis), fitted_constants(ArmDynamics(thesis))
    assert tuple(ours) == CONSTANTS
    for name in CONSTANTS:
        if name in GRAVITY:
            assert ours[name] == pytest.approx(full[name], abs=1e-9), name
        else:
            kind = [full[k] for k in CONSTANTS if k[:2] == name[:2] and k not in COUPLING]
            assert ours[name] == pytest.approx(full[name], abs=8e-3 * max(kind)), name


@pytest.mark.parametrize("arm", ARMS.values(), ids=list(ARMS))
def test_on_the_real_links_it_is_near(arm: Arm) -> None:
    """What it leaves out, c22 and link 3 off its axis, is 3 % of gravity and less of inertia."""
    ours, full = appendix_b(arm), fitted_constants(ArmDynamics(arm))
    for name in GRAVITY:
        assert ours[name] == pytest.approx(full[name], abs=0.035 * full["c21"]), name
    for joint in range(1, 7):
        name = f"b{joint}0"
        assert ours[name] == pytest.approx(full[name], rel=0.02), name
