"""``rfms conform`` on a real vcan0."""

import os
import signal
import time
from pathlib import Path

import pytest
from support.conform import failures, on_line, the_wire

from rfms_can.bus.driver import open_port, run_node
from rfms_can.conform.lines import PortLine
from rfms_can.conform.report import write_junit
from rfms_can.conform.table import CHECKS, Kind
from rfms_can.joint_nodes.joint import JointNode

pytestmark = pytest.mark.vcan

BUS = "socketcan:vcan0"
RESULTS = Path(__file__).parents[1] / "build" / "test-results"


def test_our_joint_passes_on_vcan0() -> None:
    pid = os.fork()  # imports are slow in the guest
    if not pid:
        node = JointNode(2, the_wire(), 2)
        try:
            run_node(node, open_port(BUS, node.accepts))
        finally:
            os._exit(0)
    line = PortLine(open_port(BUS, None), settle_ns=0)
    try:
        time.sleep(0.5)
        outcomes = on_line(2, line, [check for check in CHECKS if check.kind is not Kind.AXIS])
    finally:
        line.close()
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
    write_junit(RESULTS / "conform-vcan0.xml", 2, outcomes)
    assert failures(outcomes) == []
