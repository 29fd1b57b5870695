"""``rfms stability``: poles of a pose, counts of a survey, a map; bad input in one line."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from support.command_line import Ended, Rfms

from rfms_can.arm import PUMA_560
from rfms_can.cli.stability import frame_of
from rfms_can.transform import Transform

ROTATIONS = ("--word", "rx ry rz", "--tool", "0.1")
MIXED = ("--natural", "10,10,10,40,40,40")
UNSTABLE = "0.3,0.4,-2.0,0.2,0.9,0.1"


@pytest.fixture
def stability(rfms: Rfms) -> Rfms:
    return partial(rfms, "stability")


def flat(ended: Ended) -> str:
    """What was printed, without the line breaks of a narrow terminal."""
    return " ".join(ended.out.split())


def test_a_pose(stability: Rfms) -> None:
    ended = stability("--law", "weighted", "--tool", "0.2", "--compliant", "5")
    assert ended.code == 0
    assert "continuous: stable" in flat(ended)
    assert "unstable from 3.55 times the natural frequency on" in flat(ended)


def test_an_unstable_pose_is_told_by_the_exit_code(stability: Rfms) -> None:
    ended = stability(*ROTATIONS, *MIXED, "--pose", UNSTABLE)
    assert ended.code == 1
    assert "continuous: unstable" in flat(ended)
    assert ended.err == ""


def test_json_holds_all_poles(stability: Rfms) -> None:
    ended = stability("--json", "--law", "weighted", "--rate", "500")
    report = json.loads(ended.out)
    (analysis,) = report["analyses"]
    assert report["law"] == "weighted"
    assert report["rate_hz"] == 500.0
    assert analysis["q"] == list(PUMA_560.park)
    assert (len(analysis["poles"]), len(analysis["sampled"])) == (12, 18)
    assert analysis["verdict"] == analysis["on_the_bus"] == "drifts"


def test_a_path_and_random_poses(stability: Rfms, tmp_path: Path) -> None:
    path = tmp_path / "path.txt"
    path.write_text(f"# rad\n{UNSTABLE}\n\n0.1 1.4 -3.3 0.1 -1.25 0.1  # park\n")
    ended = stability(*ROTATIONS, *MIXED, "--path", path)
    assert ended.code == 1
    assert "1 of 2 poses unstable" in flat(ended) or "2 of 2 poses unstable" in flat(ended)
    drawn = [
        stability("--random", "20", "--law", "weighted", "--seed", "7", "--json") for _ in "ab"
    ]
    assert drawn[0].out == drawn[1].out
    report = json.loads(drawn[0].out)
    assert (report["poses"], report["unstable"], report["unstable_sampled"]) == (20, 0, 0)


@pytest.mark.parametrize("law", ["hybrid", "weighted"])
def test_a_map(stability: Rfms, tmp_path: Path, law: str) -> None:
    picture = tmp_path / "maps" / "map.png"
    ended = stability("--grid", "2,3", "--points", "7", "--law", law, "--plot", picture)
    assert picture.read_bytes().startswith(b"\x89PNG\r\n")
    assert f"{picture}" in ended.out.replace("\n", "")
    assert "of 49 poses unstable" in flat(ended)


def test_compliance_frames() -> None:
    assert frame_of("0.2") == Transform.translation(0.0, 0.0, 0.2)
    assert frame_of("0.1, 0, 0.2") == Transform.translation(0.1, 0.0, 0.2)
    turned = frame_of("0,0,0.2,0.3,0,0")
    np.testing.assert_allclose([turned.nx, turned.ny], [np.cos(0.3), np.sin(0.3)])


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--word", "fx fw"), "'fw' is not a direction"),
        (("--tool", "long"), "tool 'long' is not a list of numbers"),
        (("--tool", "0,1"), "give z, or x,y,z"),
        (("--pose", "1,2,3"), "six angles"),
        (("--pose", "0,1,-2,0,0,nan"), "joint 6 of puma560 at nan rad is not in its range"),
        (("--pose", "0,99,-2,0,0,0"), "joint 2 of puma560 at 99 rad is not in its range"),
        (("--points", "5"), "--points works only with a grid: give --grid"),
        (("--tool", "1e300"), "tool '1e300' is not within 10 m of the hand"),
        (("--natural", "1e-300"), "give six, 0.01 to 10000 rad/s"),
        (("--grid", "2"), "two joints"),
        (("--grid", "2,2"), "two different ones"),
        (("--grid", "2,7"), "two different ones"),
        (("--grid", "2,3", "--points", "1"), "2 to 1000"),
        (("--grid", "2,3", "--random", "5"), "give one of"),
        (("--random", "-5"), "random"),
        (("--plot", "map.png"), "give --grid"),
        (("--path", "/no/such/file"), "No such file"),
        (("--natural", "1,2"), "give six"),
        (("--arm", "puma700"), "no arm 'puma700'"),
    ],
)
def test_bad_input_is_one_line(stability: Rfms, arguments: tuple[str, ...], complaint: str) -> None:
    assert complaint in stability(*arguments).complaint


def test_a_path_without_poses_or_with_half_a_pose_is_refused(
    stability: Rfms, tmp_path: Path
) -> None:
    path = tmp_path / "path.txt"
    path.write_text("# nothing\n")
    assert "has no pose" in stability("--path", path).complaint
    path.write_text(f"{UNSTABLE}\n1 2 3\n")
    assert "line 2" in stability("--path", path).complaint
