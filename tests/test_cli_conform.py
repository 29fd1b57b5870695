"""``rfms conform`` as a user types it, on the simulated bus."""

import json
import threading
from pathlib import Path
from xml.etree import ElementTree

import pytest
from support.command_line import Rfms, run_here

from rfms_can.bus.hub.port import HubPort
from rfms_can.bus.hub.server import Hub
from rfms_can.bus.url import is_simulated
from rfms_can.cli.conform import SWITCH_ON, chosen
from rfms_can.conform import tester
from rfms_can.conform.table import CHECKS, Kind
from rfms_can.errors import RfmsError
from rfms_can.joint_nodes.detectors import setpoint_step
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Heartbeat
from rfms_can.wire.vocabulary import NodeState


@pytest.fixture
def rfms(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Rfms:
    return lambda *arguments: run_here(capsys, monkeypatch, *arguments)


def test_the_default_class_needs_a_bus_alone(rfms: Rfms) -> None:
    ended = rfms("conform", "2", "--bus", "sim", "--json")
    assert ended.code == 0
    report = json.loads(ended.out)
    assert report["failed"] == 0
    assert {check["class"] for check in report["checks"]} == {"bus"}
    assert set(report["checks"][0]) == {"id", "class", "required", "passed", "sent", "got", "want"}
    waiting = [check["id"] for check in report["checks"] if check["passed"] is None]
    assert waiting == [c.id for c in CHECKS if c.kind is Kind.BUS and c.run is None]
    assert report["passed"] == len(report["checks"]) - len(waiting)


def test_a_failure_says_what_was_sent_what_came_and_what_was_required(
    rfms: Rfms, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(setpoint_step, "STEP_MARGIN", 3.0)
    junit = tmp_path / "deep" / "results.xml"
    words = ("--check", "39", "--check", "28", "--junit", junit)
    ended = rfms("conform", "2", "--bus", "sim", "--class", "sensor", *words)
    assert ended.code == 1
    lines = ended.out.splitlines()
    assert lines[0].startswith("passed  28 ")
    assert lines[1].startswith("failed  39 ")
    assert [line.split()[0] for line in lines[2:5]] == ["sent", "got", "want"]
    assert "JOINT_SETPOINT_1" in lines[2]
    assert lines[-1] == "joint 2: 1 passed, 1 failed"
    suite = ElementTree.parse(junit).getroot()[0]
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("2", "1", "0")


def test_fail_fast_ends_at_the_first_failure(rfms: Rfms, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(setpoint_step, "STEP_MARGIN", 3.0)
    words = ("--check", "39", "--check", "40b", "--fail-fast", "--json")
    report = json.loads(rfms("conform", "2", "--bus", "sim", "--class", "sensor", *words).out)
    assert [check["id"] for check in report["checks"]] == ["39"]


def test_a_motor_moves_only_when_it_may(rfms: Rfms) -> None:
    complaint = rfms("conform", "2", "--bus", "kvaser:0", "--class", "sensor").complaint
    assert "--allow-motion" in complaint
    assert is_simulated("socketcan:vcan0") and is_simulated("hub:x") and is_simulated("sim")
    assert not is_simulated("socketcan:can0")
    assert not is_simulated("virtual:bench")


def test_wrong_words_are_told_in_one_line(rfms: Rfms) -> None:
    assert "no check '99'" in rfms("conform", "2", "--bus", "sim", "--check", "99").complaint
    needs = rfms("conform", "2", "--bus", "sim", "--check", "29").complaint
    assert needs == "rfms: check 29 needs --class sensor"
    assert "hub 'none-there'" in rfms("conform", "2", "--bus", "hub:none-there").complaint


def test_power_on_says_when_to_switch_the_node_on(
    rfms: Rfms, runtime: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The suite is on the bus by then: a HEARTBEAT sent at that line is the first frame it gets."""
    wire = Wire()
    beat = wire.sender(Heartbeat, 2).frame(NodeState.PREOP, 0, 0, 7, wire.dbc_hash, 0, 0, 0)
    hub = Hub("power")
    thread = threading.Thread(target=hub.run)
    thread.start()
    node = HubPort("power", None, client="node")
    told: list[str] = []

    def switch_on(text: str, *, err: bool) -> None:
        assert err and not told
        told.append(text)
        node.send((beat,))

    def no_answers(one: tester.Tester, seconds: float) -> None:
        frame = one.line.receive(one.line.now_ns + round(seconds * 1e9))
        assert frame == beat
        raise RfmsError("heard")

    monkeypatch.setattr("rfms_can.cli.conform.typer.echo", switch_on)
    monkeypatch.setattr(tester.Tester, "wait_for_power", no_answers)
    try:
        ended = rfms("conform", "2", "--bus", "hub:power", "--check", "1", "--power-on")
    finally:
        node.close()
        hub.stop()
        thread.join(5)
        hub.close()
    assert told == [SWITCH_ON]
    assert "heard" in ended.complaint


def test_on_the_simulated_bus_the_tester_switches_it_on(rfms: Rfms) -> None:
    ended = rfms("conform", "2", "--bus", "sim", "--check", "1", "--power-on")
    assert (ended.code, SWITCH_ON in ended.err) == (0, False)


def test_a_class_includes_those_that_need_less() -> None:
    counts = [len(chosen(kind, ())) for kind in (Kind.BUS, Kind.SENSOR, Kind.AXIS)]
    assert counts == sorted(counts)
    assert counts[-1] == len(CHECKS)


def test_the_node_that_does_not_answer_is_told(rfms: Rfms, monkeypatch: pytest.MonkeyPatch) -> None:
    from rfms_can.joint_nodes.joint import JointNode

    monkeypatch.setattr(JointNode, "on_frame", lambda *_: ())
    ended = rfms("conform", "2", "--bus", "sim", "--check", "2", "--json")
    (check,) = json.loads(ended.out)["checks"]
    assert (ended.code, check["got"]) == (1, "nothing")
