"""``rfms conform`` on a hub, with our joint in a process of its own."""

import json
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest
from support.command_line import start

from rfms_can.bus.hub.address import live_hubs
from rfms_can.cli.conform import SWITCH_ON
from rfms_can.conform.table import CHECKS

pytestmark = pytest.mark.processes

LONG_S = 180.0
JOINT = "4"


def test_our_joint_passes_on_a_hub_in_time(tmp_path: Path) -> None:
    """The suite is there first, so that it sees the node start."""
    name, junit = f"conform-{tmp_path.name}", tmp_path / "results.xml"
    hub = start("hub", name)
    suite = joint = None
    try:
        until = time.monotonic() + 20.0
        while name not in live_hubs():
            assert time.monotonic() < until
            time.sleep(0.05)
        begin = time.monotonic()
        words = ("--class", "sensor", "--power-on", "--json", "--junit", junit)
        suite = start("conform", JOINT, "--bus", f"hub:{name}", *words)
        assert suite.stderr is not None
        assert suite.stderr.readline() == f"{SWITCH_ON}\n"
        joint = start("joint", JOINT, "--bus", f"hub:{name}")
        out, err = suite.communicate(timeout=LONG_S)
        taken = time.monotonic() - begin
        again = start("conform", JOINT, "--bus", f"hub:{name}", "--check", "4", "--check", "4b")
        told_again, _ = again.communicate(timeout=LONG_S)
    finally:
        for process in (suite, joint, hub):
            if process is not None:
                process.terminate()
                process.communicate()
    assert again.returncode == 0, f"a suite leaves the node to the next: {told_again}"
    report = json.loads(out)
    wrong = [c for c in report["checks"] if c["passed"] is False]
    assert (suite.returncode, wrong) == (0, []), err
    assert report["failed"] == 0
    assert report["passed"] > 60
    assert taken < LONG_S
    cases = list(ElementTree.parse(junit).iter("testcase"))
    assert len(cases) == len(report["checks"]) == len([c for c in CHECKS if c.kind.value != "axis"])
    first = next(c for c in report["checks"] if c["id"] == "1")
    assert first["passed"], "the suite was there before the node"
