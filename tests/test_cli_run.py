"""``rfms run``: bad input is one clear line, good input is a table or one JSON object."""

import json
import sys
from pathlib import Path

import pytest
from support.command_line import Rfms
from support.system import SHORT

from rfms_can import __version__
from rfms_can.cli.options import DEFAULT_BUS, settings_from
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.codec import DBC_VARIABLE, database_hash, load_database

STILL = "def program(arm):\n    arm.sleep(0.04)\n"
POSITION = """\
from rfms_can.coordinator import Transform
def program(arm):
    there = arm.transform("there", {transform})
    goal = arm.position("goal", arm.t6 == there{configuration})
    mode = arm.mode("mode", segment_time=1.0, acceleration_time=0.2)
    arm.move(goal, mode)
"""


@pytest.fixture(autouse=True)
def directory(runtime: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A place without a config file and without hubs."""
    monkeypatch.chdir(runtime)
    return runtime


@pytest.fixture
def still(directory: Path) -> Path:
    return written(directory, STILL)


def written(directory: Path, text: str, name: str = "program.py") -> Path:
    path = directory / name
    path.write_text(text, encoding="utf-8")
    return path


# --- programs ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("def program(arm)\n    pass\n", "line 1: expected ':'"),
        ("x = 1\n", "has no function program(arm)"),
        ("program = 1\n", "has no function program(arm)"),
        (
            "async def program(arm):\n    pass\n",
            "program is a coroutine, which is never awaited here",
        ),
        ("x = 1\nx.y\n", "line 2: AttributeError"),
        ("def program(arm):\n    {}['part']\n", "line 2: KeyError: 'part'"),
        ("import json\ndef program(arm):\n    json.loads('x')\n", "line 3: JSONDecodeError"),
        ("def program(arm):\n    arm.sleep(1.0 + 'long')\n", "line 2: TypeError"),
        ("def program(arm):\n    arm.move('nowhere', 'somehow')\n", "line 2: "),
        ("def program(arm):\n    arm.gripper.close(force=7)\n", "gripper force 7 is outside 0..1"),
        ("import sys\nsys.exit(0)\n", "line 2: sys.exit(0) would end"),
        ("import sys\ndef program(arm):\n    sys.exit(0)\n", "line 3: sys.exit(0) would end"),
        ("x = 1\n\0", "null bytes"),
        ("def program(arm):\n    arm.wait(1)\n", "wait for move 1: 0 moves have been asked for"),
    ],
)
def test_a_malformed_program_is_told_by_its_line(
    rfms: Rfms, directory: Path, text: str, complaint: str
) -> None:
    path = written(directory, text)
    assert f"{path}" in (line := rfms("run", path).complaint)
    assert complaint in line


def test_a_program_may_have_modules_beside_it_and_classes_of_its_own(
    rfms: Rfms, directory: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.path", [*sys.path])
    (directory / "cell").mkdir()
    written(directory / "cell", "PLACES = 3\n", "places_of_the_cell.py")
    text = (
        "from __future__ import annotations\n"
        "from dataclasses import dataclass\n"
        "from places_of_the_cell import PLACES\n"
        "@dataclass\n"
        "class Part:\n"
        "    place: int = PLACES\n"
    )
    assert rfms("run", written(directory / "cell", text + STILL)).code == 0


def test_a_program_that_is_not_there_or_no_text(rfms: Rfms, directory: Path) -> None:
    assert "No such file" in rfms("run", directory / "none.py").complaint
    assert "directory" in rfms("run", directory).complaint
    (directory / "binary.py").write_bytes(b"\xff\x00\xfe")
    assert "cannot be read" in rfms("run", directory / "binary.py").complaint


def test_an_unreachable_position_names_the_distance_and_the_reach(
    rfms: Rfms, directory: Path
) -> None:
    text = POSITION.format(transform="Transform.translation(2.0, 0.0, 0.0)", configuration="")
    line = rfms("run", written(directory, text)).complaint
    assert "program.py, line 6" in line
    assert "to 'goal' with 'mode'" in line
    assert "2" in line and "reach is 0.4064 m" in line


def test_a_joint_limit_names_the_joint_and_the_bound(rfms: Rfms, directory: Path) -> None:
    hand = "arm.pose", ', config="right down flip"'
    text = POSITION.format(transform=hand[0], configuration=hand[1])
    line = rfms("run", written(directory, text)).complaint
    assert "joint " in line and " rad" in line and "program.py, line 6" in line


# --- settings ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("flags", "complaint"),
    [
        (["--arm", "puma9"], "there are: puma260, puma560"),
        (["--friction", "ice"], "there are: corke, thesis, none"),
        (["--servo-friction", "ice"], "there are: corke, thesis, none"),
        (["--blend", "sharp"], "there are: thesis, continuous"),
        (["--bus", "vcan0"], "A bus is sim | hub:NAME"),
        (["--bus", "sim:0"], "A bus is sim | hub:NAME"),
        (["--bus", "telepathy:0"], "python-can's interfaces are"),
        (["--bus", "socketcan:nocan7"], "bus 'socketcan:nocan7' does not exist"),
        (["--clock", "sundial"], "there are: virtual, lockstep, realtime"),
        (["--clock", "realtime"], "bus 'sim' runs in virtual time"),
        (
            ["--clock", "virtual", "--bus", "hub:x"],
            "works only on bus 'sim'; hub:x needs 'lockstep'",
        ),
        (["--rate", "333"], "rates that fit: 50, 100, 125, 200, 250"),
        (["--rate", "nan"], "rates that fit"),
        (["--rate", "-250"], "rates that fit"),
        (["--barrier", "nan"], "barrier nan s"),
        (["--patience", "0"], "patience 0 s"),
        (["--cpu", "-1"], "allowed here"),
        (["--fifo", "200"], "1 to 99"),
        (["--config", "none.toml"], "config file none.toml"),
        (["--rate", "400"], "104 % of the bus at 1000000/5000000 bit/s, which carries 384 Hz"),
        (["--rate", "fast"], "Invalid value for '--rate'"),
        (["--scene", "moon"], "there are: free, peg, surface, curved, corner"),
        (["--scene", "peg"], "stands in front of puma560, out of the reach of puma260"),
        (["--scene", "peg:x=1"], "no key 'x'; there are: x_mm, y_mm, tilt_x_deg"),
        (["--scene", "free:x_mm=1"], "no key 'x_mm'; there are: none"),
        (["--scene", "peg:x_mm=9"], "x_mm 9 is not in -5..5"),
        (["--scene", "peg:x_mm"], "x_mm= is not a number; write e.g. x_mm=0.5"),
        (["--scene", "peg:x_mm=1,x_mm=1"], "x_mm is given twice"),
        (["--scene", "surface", "--arm", "puma560", "--rate", "50000"], "rates that fit"),
        (["--sensor", "best"], "there are: none, ideal, good"),
        (["--speed", "9"], "No such option: --speed"),
        (["--record", "/dev/null/run"], "name a directory"),
    ],
    ids=" ".join,
)
def test_a_setting_that_does_not_fit_is_one_line(
    rfms: Rfms, still: Path, flags: list[str], complaint: str
) -> None:
    assert complaint in rfms("run", still, *flags).complaint


@pytest.mark.parametrize(
    ("toml", "complaint"),
    [
        ("[run\n", "config file"),
        ("[run]\nspeed = 1\n", "unknown setting speed; there are: arm, barrier"),
        ('[run]\nrate = "fast"\n', "rate is a number, not 'fast'"),
        ("[run]\narm = 260\n", "arm is a word in quotes, not 260"),
        ("[run]\nseed = 1.5\n", "seed is a whole number, not 1.5"),
        ("rate = 250\n", "one table, [run]"),
        ("[run]\nrate = 333\n", "rates that fit"),
        ("[run]\nbit_rate = 0\n", "bit rate"),
    ],
)
def test_a_config_file_that_does_not_fit_is_one_line(
    rfms: Rfms, still: Path, directory: Path, toml: str, complaint: str
) -> None:
    path = written(directory, toml, "bad.toml")
    assert complaint in rfms("run", still, "--config", path).complaint


def test_flags_beat_the_file_and_the_file_beats_the_defaults(directory: Path) -> None:
    file = written(directory, '[run]\narm = "puma560"\nrate = 200\n', "own.toml")
    assert settings_from(None) == RunSettings()
    assert settings_from(file) == RunSettings(arm="puma560", rate=200)
    assert settings_from(file, rate=500.0) == RunSettings(arm="puma560", rate=500.0)
    written(directory, '[run]\nbus = "socketcan:can0"\n', "rfms.toml")
    assert settings_from(None).bus == "socketcan:can0"
    assert settings_from(None, DEFAULT_BUS).bus == "socketcan:can0"
    assert settings_from(None, DEFAULT_BUS, bus="hub:b").bus == "hub:b"
    assert settings_from(file, DEFAULT_BUS).bus == "hub:rfms"


# --- buses and the wire -------------------------------------------------------------------------


@pytest.mark.parametrize("verb", [("joint", "3"), ("gripper",), ("plant",), ("master",)])
def test_a_node_without_its_hub_says_how_to_start_one(rfms: Rfms, verb: tuple[str, ...]) -> None:
    line = rfms(*verb, "--bus", "hub:none").complaint
    assert "no hub 'none' is running" in line and "rfms hub none" in line


def test_a_node_of_its_own_process_cannot_meet_others_on_sim(rfms: Rfms) -> None:
    assert "exists within one process" in rfms("joint", "1", "--bus", "sim").complaint


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (None, "No such file"),
        ("", "cannot be read as a DBC"),
        ("BO_ 128 SYNC: 12 MASTER\n", "SYNC: the DBC has signals"),
        ("\x00", "cannot be read as a DBC"),
    ],
)
def test_a_dbc_that_is_none_is_one_line(
    rfms: Rfms,
    still: Path,
    directory: Path,
    monkeypatch: pytest.MonkeyPatch,
    content: str | None,
    complaint: str,
) -> None:
    path = directory / "other.dbc"
    if content is not None:
        path.write_text(content)
    monkeypatch.setenv(DBC_VARIABLE, str(path))
    load_database.cache_clear()
    database_hash.cache_clear()
    try:
        assert complaint in rfms("run", still).complaint
    finally:
        load_database.cache_clear()
        database_hash.cache_clear()


# --- what comes out -----------------------------------------------------------------------------


@pytest.mark.system
def test_a_run_prints_one_json_object(rfms: Rfms) -> None:
    ended = rfms("run", SHORT, "--json")
    assert (ended.code, ended.err) == (0, "")
    result = json.loads(ended.out)
    assert result["fault"] is None
    assert result["incomplete"] == 0
    assert [joint["joint"] for joint in result["joints"]] == [1, 2, 3, 4, 5, 6]
    assert 0.0 < result["bus_load"] < result["bus_bound"] < 0.8


@pytest.mark.system
def test_a_run_shows_a_progress_line_and_a_table(rfms: Rfms) -> None:
    ended = rfms("run", SHORT, "--arm", "puma560")
    assert (ended.code, ended.out) == (0, "")
    for word in (
        "real time",
        "short_program on puma560, sim",
        "moving max",
        "deadline misses",
        "bus load",
        "frames",
    ):
        assert word in ended.err


def test_the_version_is_the_package_s(rfms: Rfms) -> None:
    assert rfms("--version") == (0, f"rfms {__version__}\n", "")


@pytest.mark.system
def test_what_a_program_prints_stays_out_of_the_json(rfms: Rfms, directory: Path) -> None:
    text = "def program(arm):\n    print('here')\n    arm.sleep(0.04)\n"
    ended = rfms("run", written(directory, text), "--json")
    assert json.loads(ended.out)["cycles"] > 0
    assert ended.err == "here\n"
