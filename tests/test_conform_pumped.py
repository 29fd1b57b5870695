"""Our joint node passes the conformance suite, called directly."""

from support.conform import failures, pumped


def test_joint_3_passes_every_required_check() -> None:
    assert failures(pumped(3)) == []
