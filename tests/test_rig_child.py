"""Child processes: they end when told, when killed, and with their parent, whatever ends it."""

import os
import signal
import sys
import time
from pathlib import Path

import pytest

from rfms_can.errors import BusError
from rfms_can.rig import child as child_module
from rfms_can.rig.child import Child, Stop, describe


def wait_for(stop: Stop) -> None:
    while not stop():
        time.sleep(0.002)


def alive(pid: int) -> bool:
    """Whether a process runs; a zombie does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def gone_within(pid: int, seconds: float) -> bool:
    until = time.monotonic() + seconds
    while alive(pid) and time.monotonic() < until:
        time.sleep(0.01)
    return not alive(pid)


def test_a_child_runs_until_it_is_told_to_stop() -> None:
    child = Child("node", wait_for)
    assert child.alive
    child.signal()
    assert child.join() == 0
    assert not child.alive
    child.signal()  # once more does no harm


def test_a_child_ends_by_itself() -> None:
    assert Child("node", lambda stop: None).join() == 0


def test_ctrl_c_is_the_parent_s_to_handle() -> None:
    ready, tell = os.pipe()

    def body(stop: Stop) -> None:
        os.write(tell, b"x")
        wait_for(stop)

    child = Child("node", body)
    os.read(ready, 1)
    os.kill(child.pid, signal.SIGINT)
    time.sleep(0.05)
    assert child.alive
    child.signal()
    assert child.join() == 0


def test_our_own_error_is_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    def body(_: Stop) -> None:
        raise BusError("the bus is not there")

    child = Child("joint 3", body)
    assert child.join() == 1
    assert capfd.readouterr().err == "joint 3: the bus is not there\n"
    ended = f"joint 3 (pid {child.pid}) has ended with exit code 1"
    assert describe(child) == f"{ended}: the bus is not there"


def test_an_error_may_be_left_to_the_parent_to_tell(capfd: pytest.CaptureFixture[str]) -> None:
    def body(_: Stop) -> None:
        raise BusError("the bus is not there")

    child = Child("master", body, quiet=True)
    assert child.join() == 1
    assert capfd.readouterr().err == ""
    assert child.error == "the bus is not there"


def test_a_bug_shows_its_trace(capfd: pytest.CaptureFixture[str]) -> None:
    def body(_: Stop) -> None:
        raise ZeroDivisionError

    assert Child("joint 3", body).join() == 1
    err = capfd.readouterr().err
    assert err.startswith("joint 3: a bug ended it\n")
    assert "ZeroDivisionError" in err


def test_a_child_that_does_not_listen_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child_module, "PATIENCE_S", 0.1)
    child = Child("node", lambda stop: wait_for(lambda: False))
    child.signal()
    assert child.join() == -signal.SIGKILL


@pytest.mark.skipif(sys.platform != "linux", reason="looks at /proc")
def test_a_child_does_not_outlive_a_parent_that_is_killed() -> None:
    ready, tell = os.pipe()

    def parent(stop: Stop) -> None:
        child = Child("grandchild", wait_for)
        os.write(tell, child.pid.to_bytes(4, "little"))
        wait_for(stop)

    middle = Child("child", parent)
    grandchild = int.from_bytes(os.read(ready, 4), "little")
    assert alive(grandchild)
    os.kill(middle.pid, signal.SIGKILL)
    assert middle.join() == -signal.SIGKILL
    assert gone_within(grandchild, 5.0)
