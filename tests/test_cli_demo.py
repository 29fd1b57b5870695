"""``rfms demo``: the peg goes in, and its numbers and picture come out, for people and as JSON."""

import json
from pathlib import Path

import pytest
from support.command_line import Rfms

pytestmark = pytest.mark.system


@pytest.mark.parametrize("as_json", [False, True])
def test_the_demo_tells_how_the_peg_went_in_and_draws_it(
    tmp_path: Path, rfms: Rfms, as_json: bool
) -> None:
    picture = tmp_path / "peg.png"
    words = ("--json",) if as_json else ()
    ended = rfms("demo", "--picture", picture, *words)
    assert ended.code == 0
    assert picture.read_bytes().startswith(b"\x89PNG\r\n")
    if as_json:
        report = json.loads(ended.out)
        assert report["picture"] == str(picture)
        assert report["peg"]["depth"] > 0.039
        assert 0.0 < report["peg"]["lateral_mean"] < report["peg"]["lateral_peak"] < 60.0
    else:
        assert "40.0 mm deep" in ended.err
        assert picture.name in ended.err.replace("\n", "")
