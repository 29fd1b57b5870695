"""Our joint node passes the conformance suite, called directly and on the simulated bus."""

import pytest
from support.conform import failures, on_line, pumped, simulated, the_wire

from rfms_can.conform.lines import PumpedLine
from rfms_can.conform.outcome import Verdict
from rfms_can.conform.table import CHECKS
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.wire.nodes import JOINTS

FAST = ("29", "30", "30b", "40e", "8")
"""Checks that take half of the time; joint 3 has them all."""


def test_joint_3_passes_every_check() -> None:
    outcomes = pumped(3)
    assert failures(outcomes) == []
    assert [o.id for o in outcomes] == [check.id for check in CHECKS]
    waiting = {check.id for check in CHECKS if check.run is None}
    assert {o.id for o in outcomes if o.verdict is Verdict.PENDING} == waiting
    assert [o.id for o in outcomes if o.verdict is Verdict.SKIPPED] == ["51"], "it is of real time"


@pytest.mark.parametrize("joint", [joint for joint in JOINTS if joint != 3])
def test_the_others_pass_what_depends_on_the_joint(joint: int) -> None:
    line = PumpedLine(lambda: JointNode(joint, the_wire(), joint))
    assert failures(on_line(joint, line, [c for c in CHECKS if c.id not in FAST])) == []


@pytest.mark.system
@pytest.mark.parametrize("joint", JOINTS)
def test_every_joint_passes_on_the_simulated_bus(joint: int) -> None:
    outcomes = simulated(joint)
    assert failures(outcomes) == []
    assert [o.id for o in outcomes if o.verdict is Verdict.SKIPPED] == ["51"], "it is of real time"
