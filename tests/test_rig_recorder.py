"""The process that writes the log of a bus: whole, cut by a full disk, or killed."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from rfms_can.bus.hub.port import HubPort
from rfms_can.rig.candump import read_candump
from rfms_can.rig.processes import start_hub
from rfms_can.rig.recorder import Recorder
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.frame import Frame

pytestmark = [pytest.mark.processes, pytest.mark.usefixtures("runtime")]

SETTINGS = RunSettings(bus="hub:log")


@pytest.fixture
def port(runtime: Path) -> Iterator[HubPort]:
    hub = start_hub(SETTINGS)
    assert hub is not None
    port = HubPort("log", echo=True)
    yield port
    port.close()
    hub.signal()
    hub.join()


def test_a_log_that_is_whole_is_not_flagged(port: HubPort, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "bus.log", SETTINGS)
    witness = tmp_path / "bus.log"
    while not witness.exists():
        assert recorder.alive
    port.send([Frame(2, b"last")])
    recorder.close()
    assert recorder.cut == ""
    assert read_candump(witness)[-1][1] == Frame(2, b"last")


def test_a_log_that_is_cut_is_told_to_the_parent(
    port: HubPort, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "bus.log"
    log.symlink_to("/dev/full")
    recorder = Recorder(log, SETTINGS)
    for _ in range(200):
        port.send([Frame(2, b"a frame")])
        port.recv(0.01)
    recorder.close()
    assert recorder.exit_code == 0
    assert recorder.cut == "No space left on device"
    assert f"recorder: {log} is cut: No space left on device" in capfd.readouterr().err


def test_a_recorder_that_was_killed_has_left_no_whole_log(port: HubPort, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "bus.log", SETTINGS)
    os.kill(recorder.pid, signal.SIGKILL)
    recorder.close()
    assert "recorder" in recorder.cut
    assert "exit code -9" in recorder.cut
