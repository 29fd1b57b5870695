"""Which joint the master names where several stray."""

import numpy as np

from rfms_can.arm import PUMA_560
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.master.verification import CYCLES, Verification
from rfms_can.wire.nodes import JOINTS

AT = (0.3, -0.4, 0.5, 0.1, 0.7, -0.2)
SLIGHTLY = (0.0, 0.11, 0.0, 0.0, 0.0, 0.0)
BOTH = (0.0, 0.11, 0.0, 0.0, 0.3, 0.0)


def less(errors: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(at - error for at, error in zip(AT, errors, strict=True))


def test_one_that_strays_farther_but_only_now_is_not_the_one_that_is_named() -> None:
    verification = Verification(all_parameters(PUMA_560, "corke", 0.004))
    for _ in range(CYCLES - 1):
        assert verification.check(AT, None, less(SLIGHTLY), SLIGHTLY) is None
    reason = verification.check(AT, None, less(BOTH), BOTH)
    assert reason is not None
    assert reason.words.startswith("joint 2 does not follow: MEASURE_2 is")


def test_of_several_that_stray_the_one_farthest_over_its_bound_is_named() -> None:
    verification = Verification(all_parameters(PUMA_560, "corke", 0.004))
    errors = tuple(
        1.1 * b * (2.0 if joint == 6 else 1.0)
        for joint, b in zip(JOINTS, verification.bounds, strict=True)
    )
    for _ in range(CYCLES):
        reason = verification.check(AT, None, less(errors), errors)
    assert reason is not None
    assert reason.words.startswith("joint 6 does not follow: MEASURE_6 is")


def test_an_arm_that_complies_and_is_off_in_every_joint_is_found() -> None:
    verification = Verification(all_parameters(PUMA_560, "corke", 0.004))
    errors = (0.5,) * 6
    for _ in range(CYCLES):
        reason = verification.check(AT, None, less(errors), errors, 0b111111, np.eye(6))
    assert reason is not None and "does not follow" in reason.words


def test_where_rows_mix_errors_the_joint_farthest_off_is_named_with_the_part_that_is_held() -> None:
    """Joint 5 is let go, and row 3 is held to nine tenths of its error."""
    verification = Verification(all_parameters(PUMA_560, "corke", 0.004))
    errors = (0.0, 0.0, 0.0, 0.0, 0.3, 0.0)
    held = np.zeros((6, 6))
    held[2, 4] = 0.9
    for _ in range(CYCLES):
        reason = verification.check(AT, None, less(errors), errors, 0b111111, held)
    assert reason is not None and reason.words.startswith("joint 5 does not follow")
    bound = 2.0 * verification.bounds[2]
    assert f"(held part off by 0.2700 rad, bound {bound:g} rad, 3 cycles)" in reason.words
