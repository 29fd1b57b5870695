"""tools/with-vcan runs a command on a real vcan0 as if it ran here, and leaves nothing behind."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

WITH_VCAN = Path(__file__).parents[1] / "tools" / "with-vcan"
PROBE = Path(__file__).parent / "support" / "programs" / "with_vcan_probe.py"
AWKWARD = ["two words", "it's", 'a "quote"', "", "$HOME *", "back\\slash", "--json"]
PATIENCE_S = 60.0


def with_vcan(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, WITH_VCAN, *arguments],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
        **options,
    )


@pytest.fixture(scope="module")
def way() -> str:
    """How commands run on this machine; skips the test if they cannot."""
    checked = with_vcan("--check")
    if checked.returncode != 0:
        unavailable = f"no vcan0 on this machine: {checked.stderr.strip()}"
        if os.environ.get("RFMS_REQUIRE_VCAN") == "1":
            pytest.fail(unavailable)
        pytest.skip(unavailable)
    return checked.stdout.partition(":")[0]


@pytest.fixture(scope="module")
def directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("a directory")


@pytest.fixture(scope="module")
def probed(way: str, directory: Path) -> subprocess.CompletedProcess[str]:
    """One command that looks around inside; several tests read what it found."""
    assert way in {"native", "user-mode kernel"}
    environment = {**os.environ, "WITH_VCAN_TEST": "two\nlines"}
    return with_vcan(sys.executable, str(PROBE), *AWKWARD, cwd=directory, env=environment)


@pytest.mark.system
def test_exit_code_is_the_command_s(probed: subprocess.CompletedProcess[str]) -> None:
    assert probed.returncode == 7, probed.stderr


@pytest.mark.system
def test_outputs_arrive_apart_and_without_the_kernel_s(
    probed: subprocess.CompletedProcess[str],
) -> None:
    assert probed.stderr == "a complaint\n"
    assert len(probed.stdout.splitlines()) == 1


@pytest.mark.system
def test_command_finds_what_it_would_have_found_here(
    probed: subprocess.CompletedProcess[str], directory: Path
) -> None:
    report = json.loads(probed.stdout)
    assert report["arguments"] == AWKWARD
    assert report["directory"] == str(directory)
    assert report["variable"] == "two\nlines"
    assert report["user"] == os.getuid()


@pytest.mark.system
@pytest.mark.usefixtures("probed")
def test_files_written_inside_are_whole_outside(directory: Path) -> None:
    assert (directory / "left by the command").read_text() == "whole\n" * 10_000


@pytest.mark.system
def test_processes_exchange_can_fd_frames(probed: subprocess.CompletedProcess[str]) -> None:
    report = json.loads(probed.stdout)
    assert report["mtu"] == 72
    assert report["answer"] == [0x321, bytes(range(64))[::-1].hex(), True, True]


@pytest.mark.system
def test_candump_records(probed: subprocess.CompletedProcess[str]) -> None:
    identifier, flags_and_data = json.loads(probed.stdout)["record"].split("##")
    assert identifier == "140"
    assert int(flags_and_data[0], 16) & 1  # bit-rate switching; newer kernels add FDF
    assert flags_and_data[1:] == "00" * 12


def processes_of(directory: Path) -> list[str]:
    """The command lines of running processes that name a directory."""
    found = []
    for process in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            line = process.read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:  # it has ended meanwhile
            continue
        if str(directory) in line:
            found.append(line)
    return found


@pytest.mark.system
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_no_signal_leaves_anything_behind(way: str, tmp_path: Path, number: int) -> None:
    if way == "native":
        pytest.skip("the command replaces with-vcan on a kernel that has vcan")
    command = [sys.executable, str(WITH_VCAN), "sh", "-c", "echo started; sleep 1000"]
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"started\n"
        assert processes_of(tmp_path)
        process.send_signal(number)
        code = process.wait(PATIENCE_S)
    assert code == (-number if number == signal.SIGKILL else 128 + number)
    patience = time.monotonic() + (5.0 if number == signal.SIGKILL else 0.0)
    while time.monotonic() < patience and (processes_of(tmp_path) or os.listdir(tmp_path)):
        time.sleep(0.05)
    assert processes_of(tmp_path) == []
    assert os.listdir(tmp_path) == []


@pytest.mark.system
@pytest.mark.usefixtures("way")
def test_time_limit_ends_the_command_and_keeps_its_files(tmp_path: Path) -> None:
    done = with_vcan(
        "--timeout", "0.5", "sh", "-c", "echo kept > file; exec sleep 1000", cwd=tmp_path
    )
    assert done.returncode == 124
    assert (tmp_path / "file").read_text() == "kept\n"


@pytest.mark.system
@pytest.mark.usefixtures("way")
def test_bare_exchange_compiles_without_warnings_and_runs(tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    program = tmp_path / "vcan_exchange"
    source = WITH_VCAN.with_name("vcan_exchange.c")
    options = ["-O2", "-Wall", "-Wextra", "-Werror"]
    subprocess.run([compiler, *options, "-o", program, source], check=True)
    done = with_vcan(str(program), "--json", "20")
    assert done.returncode == 0, done.stderr
    measured = json.loads(done.stdout)
    assert measured["cycles"] == 20
    assert measured["cycles_per_s"] == pytest.approx(20 / measured["seconds"], rel=1e-3)


@pytest.mark.system
@pytest.mark.usefixtures("way")
def test_unknown_command_is_named() -> None:
    done = with_vcan("no-such-command")
    assert done.returncode == 127
    assert done.stderr == "with-vcan: no-such-command: No such file or directory\n"


def test_machine_without_either_is_told_what_to_install(tmp_path: Path) -> None:
    if with_vcan("--check").stdout.startswith("native"):
        pytest.skip("this kernel has vcan")
    done = with_vcan("true", env={"PATH": str(tmp_path)})
    assert done.returncode == 69
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert "apt-get install user-mode-linux can-utils" in line


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ([], "no command"),
        (["--memory", "4", "true"], "'4' is not a size"),
        (["--timeout", "0", "true"], "'0' is not between 0 and 1e6 seconds"),
        (["--timeout", "soon", "true"], "'soon' is not between"),
        (["--no-such-option", "true"], "--no-such-option"),
    ],
)
def test_wrong_usage_is_refused(arguments: list[str], complaint: str) -> None:
    done = with_vcan(*arguments)
    assert done.returncode == 2
    assert complaint in done.stderr.splitlines()[-1]
