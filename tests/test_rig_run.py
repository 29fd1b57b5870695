"""One run from settings to record: what is written, what ends it, and how safe the arm is then."""

import json
import os
import re
import signal
from array import array
from pathlib import Path

import can
import cantools
import pytest
from support.bus_nodes import Listener
from support.system import SHORT

from rfms_can.arm import PUMA_260
from rfms_can.cli.report import console, print_result, print_rows
from rfms_can.coordinator import Arm, stopping
from rfms_can.errors import FaultError, ProgramError, RfmsError
from rfms_can.kinematics import direct
from rfms_can.master.phases import Phase
from rfms_can.master.stillness import Stillness
from rfms_can.rig import candump
from rfms_can.rig.interrupt import Interrupt, signals_noted
from rfms_can.rig.program import load_program
from rfms_can.rig.record import COMMANDED, LOG, SETTINGS, SUMMARY, Record
from rfms_can.rig.runner import Outcome, execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.codec import database_path
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.records import Estop

pytestmark = pytest.mark.system

SETTINGS_USED = RunSettings(seed=7)
SHORT_STOPPING_S = 2.0
"""How long an arm may take to come to rest, in a test in which it never does."""


class Watched:
    """Keeps the rig of a run, to look at it after the run and to interfere."""

    def __init__(self) -> None:
        self.rig: SimulatedRig

    def __call__(self, rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        self.rig = rig

    def assert_safe(self) -> None:
        """All brakes on, the master through with it, the arm at a standstill."""
        assert all(self.rig.master.arm_state.braked)
        assert self.rig.master.phase is Phase.END
        assert max(map(abs, self.rig.plant.physics.true_qd)) < 1e-3


@pytest.fixture
def watched() -> Watched:
    return Watched()


def swing(arm: Arm, then: str = "wait") -> None:
    """A motion that takes a second."""
    there = arm.transform("there", arm.pose)
    turned = arm.transform("turned", type(arm.pose).rotation((0.0, 0.0, 1.0), 0.5))
    goal = arm.position("goal", arm.t6 == turned @ there)
    arm.move(goal, arm.mode("mode", segment_time=1.0, acceleration_time=0.2))
    if then == "wait":
        arm.wait()
    else:
        arm.sleep(0.5)


@pytest.fixture(scope="module")
def short_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Outcome]:
    """A recording of the short program, and how the run ended."""
    directory = tmp_path_factory.mktemp("short") / "deep" / "run"
    return directory, execute(load_program(SHORT), SETTINGS_USED, record=directory)


def test_a_recording_is_whole(short_run: tuple[Path, Outcome]) -> None:
    directory, outcome = short_run
    assert {file.name for file in directory.iterdir()} == {LOG, SETTINGS, COMMANDED, SUMMARY}
    summary = json.loads((directory / SUMMARY).read_text())
    assert summary == outcome.result.as_dict()
    settings = json.loads((directory / SETTINGS).read_text())
    assert settings["settings"] == SETTINGS_USED.as_dict()
    assert RunSettings(**settings["settings"]) == SETTINGS_USED
    assert settings["dbc_hash"] == Wire().dbc_hash
    assert {"python", "rfms_can", "mujoco", "pin", "cantools"} <= settings["versions"].keys()
    rows = (directory / COMMANDED).read_text().splitlines()
    assert rows[0] == "cycle,q1,q2,q3,q4,q5,q6"
    assert len(rows) - 1 == pytest.approx(summary["cycles"], abs=2)


def test_everybody_s_tools_read_the_log(short_run: tuple[Path, Outcome]) -> None:
    database = cantools.database.load_file(database_path())
    names = set()
    for message in can.LogReader(str(short_run[0] / LOG)):
        assert isinstance(message, can.Message)
        described = database.get_message_by_frame_id(message.arbitration_id)
        described.decode(bytes(message.data), allow_truncated=False)
        names.add(described.name)
    assert {"SYNC", "SETPOINT_1", "MEASURE_7", "ERROR_6", "ROWS_1", "HEARTBEAT_8", "NMT"} <= names


def test_an_earlier_recording_is_replaced(tmp_path: Path) -> None:
    for name in (LOG, SETTINGS, COMMANDED, SUMMARY):
        (tmp_path / name).write_text("of an earlier run")
    Record(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == [LOG]
    assert (tmp_path / LOG).read_bytes() == b""


def test_a_record_that_cannot_be_written_says_so(tmp_path: Path) -> None:
    record = Record(tmp_path)
    (tmp_path / COMMANDED).mkdir()
    with pytest.raises(RfmsError, match=r"commanded.csv cannot be written"):
        record.commanded(array("d"))


def test_a_log_that_is_cut_is_flagged_and_the_run_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Control is unharmed: what is missing is told in the result, its text and its file."""
    monkeypatch.setattr(candump, "BUFFERED_BYTES", 1 << 14)
    whole = execute(load_program(SHORT), SETTINGS_USED, record=tmp_path / "whole").result

    def full(directory: Path) -> Record:
        record = Record(directory)
        record.log.unlink()
        record.log.symlink_to("/dev/full")
        (directory / COMMANDED).mkdir()
        return record

    monkeypatch.setattr("rfms_can.rig.runner.Record", full)
    result = execute(load_program(SHORT), SETTINGS_USED, record=tmp_path / "cut").result
    assert (result.fault, result.error) == (None, None)
    assert (result.cycles, result.frames) == (whole.cycles, whole.frames)
    assert whole.unrecorded == []
    log, commanded = result.unrecorded
    assert log == "bus.log is cut: No space left on device"
    assert "commanded.csv cannot be written" in commanded
    assert json.loads((tmp_path / "cut" / SUMMARY).read_text())["unrecorded"] == result.unrecorded
    with console.capture() as told:
        print_result("a run", result)
    assert "record incomplete: bus.log is cut: No space left on device" in told.get()


def test_a_program_s_error_stops_the_moving_arm_on_its_path(watched: Watched) -> None:
    def program(arm: Arm) -> None:
        swing(arm, "fail while it moves")
        raise ProgramError("enough")

    with pytest.raises(ProgramError, match="enough"):
        execute(program, RunSettings(), watch=watched)
    watched.assert_safe()
    assert watched.rig.master.fault is None


def test_a_refused_request_changes_nothing(watched: Watched) -> None:
    def program(arm: Arm) -> None:
        swing(arm)
        before = arm.joints
        with pytest.raises(ProgramError):
            arm.move("nowhere", "mode")
        arm.sleep(0.1)
        assert arm.joints == pytest.approx(before, abs=1e-3)

    assert execute(program, RunSettings(), watch=watched).fault is None


def test_an_emergency_stop_is_a_latched_fault(watched: Watched, tmp_path: Path) -> None:
    def program(arm: Arm) -> None:
        swing(arm, "go on")
        bus, wire = watched.rig.bus, Wire()
        plant = bus.attach(Listener("bystander", frozenset()))
        bus.send(plant, [wire.sender(Estop).frame(*ESTOP_VALUES)])
        arm.wait()
        raise AssertionError("the arm was stopped, and the program not told")

    outcome = execute(program, RunSettings(), watch=watched, record=tmp_path)
    assert isinstance(outcome.fault, FaultError)
    assert "emergency stop" in str(outcome.fault).lower() or "EMERGENCY_STOP" in str(outcome.fault)
    assert json.loads((tmp_path / SUMMARY).read_text())["fault"] == str(outcome.fault)
    watched.assert_safe()


@pytest.mark.parametrize("at", ["before it is enabled", "while it moves"])
def test_an_interrupt_leaves_the_arm_braked(watched: Watched, at: str) -> None:
    interrupt = Interrupt()

    def program(arm: Arm) -> None:
        swing(arm, "interrupt while it moves")
        interrupt.signal = signal.SIGINT
        arm.wait()
        raise AssertionError("the program was not interrupted")

    if at == "before it is enabled":
        interrupt.signal = signal.SIGTERM
    with pytest.raises(KeyboardInterrupt):
        execute(program, RunSettings(), watch=watched, interrupted=interrupt)
    assert watched.rig.master.phase is Phase.END
    if at == "while it moves":
        watched.assert_safe()
        assert interrupt.exit_code == 130
    else:
        assert interrupt.exit_code == 143


def test_an_arm_that_never_rests_is_braked_after_a_while(
    watched: Watched, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its servos shake it: what ends the program is told all the same."""
    monkeypatch.setattr(Stillness, "arm", property(lambda _: False))
    monkeypatch.setattr(stopping, "STOPPING_S", SHORT_STOPPING_S)

    def program(arm: Arm) -> None:
        raise ProgramError("enough")

    with pytest.raises(ProgramError, match="enough"):
        execute(program, RunSettings(), watch=watched)
    assert watched.rig.master.phase is Phase.END
    assert watched.rig.master.statistics.cycles >= SHORT_STOPPING_S * RunSettings().rate
    watched.assert_safe()


def test_a_signal_is_noted_once_and_then_felt() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(KeyboardInterrupt), signals_noted() as interrupt:
        assert not interrupt()
        os.kill(os.getpid(), signal.SIGTERM)
        assert interrupt()
        assert interrupt.exit_code == 143
        os.kill(os.getpid(), signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_rig_that_cannot_be_watched_is_given_back() -> None:
    def refuse(_: Rig) -> None:
        raise RfmsError("not permitted")

    with pytest.raises(RfmsError, match="not permitted"):
        execute(load_program(SHORT), RunSettings(), watch=refuse)


def test_a_result_tells_the_singularities_met_while_complying(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def near_the_wrist(arm: Arm) -> None:
        angles = list(PUMA_260.park)
        angles[4] = 0.02
        there = arm.transform("there", direct(PUMA_260, angles))
        goal = arm.position("goal", arm.t6 == there)
        arm.wait(arm.move(goal, arm.mode("far", segment_time=1.5, acceleration_time=0.3)))
        arm.wait(
            arm.move(
                goal, arm.mode("soft", segment_time=0.5, acceleration_time=0.1, comply={"rx": 0.0})
            )
        )

    result = execute(near_the_wrist, SETTINGS_USED).result
    words = result.reported[0]
    for told in result.reported:
        assert re.fullmatch(r"near a singularity \w\w.* beside rx could not be held", told)
    assert len(set(result.reported)) == len(result.reported)
    assert result.as_dict()["reported"] == result.reported
    print_result("near the wrist", result)
    assert f"compliance {words}" in " ".join(capsys.readouterr().err.split())


def test_what_stands_in_brackets_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    print_rows([("picture", "none: pip install 'rfms_can[viz]'")])
    assert "rfms_can[viz]" in capsys.readouterr().err


def test_boot_ids_are_drawn_at_every_start_where_nodes_are_processes() -> None:
    """A seed makes a run repeat; without one a node that starts again has another boot id."""
    on_a_hub = RunSettings(bus="hub:any")
    drawn = {on_a_hub.boot_id(3) for _ in range(8)}
    assert len(drawn) == 8
    assert all(0 <= boot_id < 1 << 32 for boot_id in drawn)
    for settings in (RunSettings(bus="hub:any", seed=5), RunSettings(seed=5)):
        assert settings.boot_id(3) == settings.boot_id(3) == 0x503
    assert RunSettings().boot_id(3) == RunSettings(seed=1).boot_id(3)
