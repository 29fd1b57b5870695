"""An arm that follows a camera: a few seeds of the campaign, and its kept table."""

from pathlib import Path
from typing import Any

import pytest
from servoing import table
from servoing.results import KEPT, read
from servoing.scene import draw
from servoing.trial import Result, Servoing

from rfms_can.arm import ARMS, arm_by_name

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize("arm", ARMS)
def test_the_arm_keeps_its_limits_whatever_the_camera_says(arm: str) -> None:
    results = [Servoing(arm_by_name(arm), draw(arm_by_name(arm), k), k).run() for k in range(10)]
    assert [each for each in results if table.broken(each)] == []
    assert any(each.short for each in results) and not all(each.short for each in results)


GOOD = Result("puma260", 1, "still", "hold", 50, 5e-4, 0.0, "", 0, 0.3, 0.5, 1, 0.001, 0)


@pytest.mark.parametrize(
    "worse", [{"fault": "joint 4: SETPOINT_STEP"}, {"acceleration": 1.03}, {"off": 0.0051}]
)
def test_the_judge_sees_a_broken_promise(worse: dict[str, Any]) -> None:
    assert not table.broken(GOOD)
    assert table.broken(GOOD._replace(**worse))
    assert not table.broken(GOOD._replace(noise=0.001, off=0.006))  # more noise than promised for


def test_the_kept_campaign_keeps_the_promise() -> None:
    _, results = read(ROOT / KEPT)
    assert len(results) >= 1000
    assert {each.arm for each in results} == set(ARMS)
    assert [each for each in results if table.broken(each)] == []
