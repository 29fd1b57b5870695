"""The pieces of docs/task-level.md are one program, and print what stands there."""

import re
from pathlib import Path
from typing import Any

import pytest
from support.system import run

from rfms_can import task
from rfms_can.coordinator import Arm
from rfms_can.task import Step, primitives

PAGE = Path(__file__).parents[1] / "docs" / "task-level.md"
TEXT = PAGE.read_text(encoding="utf-8")
PIECES = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
(PRINTED,) = re.findall(r"```text\n(.*?)```", TEXT, re.DOTALL)


def piece(number: int, names: dict[str, Any]) -> None:
    exec(compile(PIECES[number], f"{PAGE.name}, piece {number}", "exec"), names)


def test_a_task_prints_as_on_the_page(capsys: pytest.CaptureFixture[str]) -> None:
    piece(0, {})
    assert capsys.readouterr().out == PRINTED


@pytest.mark.system
def test_the_pieces_are_one_program(capsys: pytest.CaptureFixture[str]) -> None:
    ran: list[int] = []

    def program(arm: Arm) -> None:
        names: dict[str, Any] = {"arm": arm}
        for number in range(len(PIECES)):
            piece(number, names)
            ran.append(number)

    run(program, "surface:z_mm=-7", sensor="good")
    assert len(ran) == len(PIECES) == 7
    told = capsys.readouterr().out.removeprefix(PRINTED).splitlines()
    assert [line.partition(":")[0] for line in told] == ["guarded approach plate", "approach place"]
    assert re.search(r"no contact after (29.9|30.[01]) mm", told[0])


def test_every_motion_and_every_step_is_on_the_page() -> None:
    public = set(task.__all__) - {"Step", "Report", "MOUTH", "GUIDED"}
    steps = {name for name in public if is_step(getattr(task, name))}
    motions = {name for name in public if getattr(primitives, name, None) is getattr(task, name)}
    told = set(re.findall(r"`(\w+)", TEXT))
    hidden = {"DefineTransform", "DefinePosition", "DefineMode", "Touch", "Insertion", "Follow"}
    assert {*steps, *motions} - told == hidden


def is_step(thing: object) -> bool:
    return isinstance(thing, type) and issubclass(thing, Step)
