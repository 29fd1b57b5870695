"""Tasks on the simulated bus: contact, insertion, a belt; and that they leave nothing behind."""

import asyncio
import math
import re
from typing import Any

import pytest
from example_run import example, origin
from support.link import AsyncCoreSocket, CoreSocket
from support.server import ServerBench
from support.system import across, pushed, run

from rfms_can.coordinator import Arm, Outcome, ProgramError, Transform, connect_async
from rfms_can.plant.scene.catalogue import scene_from
from rfms_can.rig.runner import execute
from rfms_can.rig.settings import RunSettings
from rfms_can.task import Frame, Report, Task, approach, depart, follow, guarded_approach
from rfms_can.wire.contract import Wire

HOLE = "peg:x_mm=1,tilt_x_deg=0.5"


def in_scene(program: Any, scene: str, **settings: Any) -> None:
    made = RunSettings(arm="puma560", scene=scene, friction="thesis", dither=0.9, **settings)
    outcome = execute(program, made)
    assert outcome.fault is None
    assert outcome.result.incomplete == 0


def is_gone(arm: Arm, task: Task) -> bool:
    """Whether the server has none of its names any more."""
    for step in task.steps:
        if hasattr(step, "name"):
            with pytest.raises(ProgramError, match="no transform, position or mode has this name"):
                arm.remove(task.scope.full(step.name))
    return True


# --- a peg ---------------------------------------------------------------------------------------


@pytest.mark.system
@pytest.mark.parametrize("settings", [{"sensor": "good"}, {}])
def test_a_misaligned_peg_goes_in_and_out_again(
    settings: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    module = example("task_level")
    moments = run(module.program, HOLE, dither=0.9, **settings)
    said = capsys.readouterr().out
    depth, peak = -min(m.truth.tip.pz for m in moments), across(moments).max()
    print(f"{settings}: {1e3 * depth:.1f} mm deep, {peak:.1f} N across at most")
    printed = str(module.assembly("sensor" in settings))
    assert said.startswith(printed)
    assert re.fullmatch(r"\n(39\.\d|40\.\d) mm deep, in 6 moves\n", said.removeprefix(printed))
    assert depth > 0.039
    assert peak < 40.0
    assert moments[-1].truth.tip.pz > 0.004
    assert moments[-1].status.comply == ""


@pytest.mark.system
def test_beside_the_hole_the_task_says_how_deep_and_leaves_nothing() -> None:
    module = example("task_level")
    gone: list[bool] = []

    def program(arm: Arm) -> None:
        task: Task = module.assembly(True)
        arm.gripper.close()
        with pytest.raises(ProgramError, match=r"^insert hole: -?\d\.\d of 40 mm deep: .* reached"):
            task.run(arm)
        assert arm.status.at_rest
        gone.append(is_gone(arm, task))

    in_scene(program, "peg:x_mm=5,y_mm=-4", sensor="good")
    assert gone == [True]


def test_the_example_has_the_numbers_of_its_scene() -> None:
    module, built = example("task_level"), scene_from("peg", "puma560")
    assert built.tool is not None
    assert module.PEG.values == {"peg": built.tool.tip}
    assert module.HOLE.values == {"hole": built.place @ module.DOWN}
    assert module.PEG_LOAD["mass"] == pytest.approx(built.tool.mass, abs=5e-5)
    assert module.PEG_LOAD["mass_centre"] == pytest.approx(built.tool.com, abs=5e-5)


# --- contact -------------------------------------------------------------------------------------


@pytest.mark.system
def test_contact_is_met_where_it_is_and_missed_where_it_is_not() -> None:
    known = example("touch")
    tip, place = Frame("tip", known.TIP), Frame("place", known.PLACE @ known.DOWN)
    load = {"segment_time": 1.5, "mass": known.TOOL_MASS, "mass_centre": known.TOOL_CENTRE}
    reports: list[Report] = []

    def program(arm: Arm) -> None:
        touch = guarded_approach(
            tip, place, force={"fz": 10.0}, by=(0.0, 0.0, -0.02), far=load, tare=True
        )
        reports.append(touch.run(arm))
        depart(tip, place, by=(0.0, 0.0, -0.03)).run(arm)
        short = guarded_approach(tip, place, force={"fz": 10.0}, by=(0, 0, -0.02), at_most=0.015)
        told = r"^guarded approach place: no contact after 1[45]\.\d mm.*larger at_most"
        with pytest.raises(ProgramError, match=told):
            short.run(arm)
        assert is_gone(arm, touch) and is_gone(arm, short)

    moments = run(program, "surface:z_mm=-7", sensor="good")
    (report,) = reports
    assert [one.how for one in report.outcomes] == [Outcome.MADE, Outcome.GUARDED]
    assert report.travelled == pytest.approx(0.027, abs=2e-4)
    assert 10.0 < pushed(moments, 2).max() < 60.0


# --- a belt --------------------------------------------------------------------------------------


@pytest.mark.system
def test_a_belt_is_followed_for_a_time_and_then_left_or_followed_on() -> None:
    module = example("conveyor")
    tool, down = Frame("tool", Transform.translation(0.0, 0.0, 0.1354)), Frame("down", module.DOWN)
    off: dict[str, float] = {}

    def distance(arm: Arm, belt: Any) -> float:
        tip = arm.pose @ tool.values["tool"]
        return math.dist(origin(tip), origin(belt.part(arm.time)))

    def program(arm: Arm) -> None:
        belt = module.Belt(arm.pose, module.SPEED, module.coming(arm.time))
        part = arm.reference("part", belt.picture(arm.time), predict="velocity")

        def look(arm: Arm) -> None:
            taken = arm.time - module.LATE
            arm.observe(part, belt.picture(taken), at=taken)

        entry = Frame("entry", belt.at(module.REACH + module.AHEAD * module.SPEED)) @ down
        waits = entry @ Frame("over", Transform.translation(0.0, 0.0, -0.05))
        approach(tool, waits, by=(0.0, 0.0, -0.02)).run(arm)
        while arm.time < belt.enters:
            arm.sleep(module.FRAME)
            look(arm)
        over = follow(tool, part @ down, duration=0.1, look=look, by=(0, 0, -0.05), keep=True)
        there = follow(tool, part @ down, duration=0.3, look=look, keep=True)
        for task in (over, there):
            task.named("ride").run(arm)
            assert is_gone(arm, task.named("ride"))
        off["follows"] = distance(arm, belt)
        assert not arm.status.at_rest
        follow(tool, part @ down, duration=0.0, look=look).run(arm)
        arm.wait()
        assert arm.status.at_rest
        arm.sleep(0.1)
        off["left"] = distance(arm, belt)
        for _ in range(10):
            look(arm)
            arm.sleep(module.FRAME)
        off["observed"] = distance(arm, belt)
        arm.remove(part)

    outcome = execute(program, RunSettings())
    assert outcome.fault is None
    print(f"{1e3 * off['follows']:.2f} mm off while it follows, {1e3 * off['left']:.2f} mm after")
    assert off["follows"] < 1e-3
    assert off["left"] > 8e-3
    assert off["observed"] == pytest.approx(
        off["left"] + 10 * module.FRAME * module.SPEED, abs=1e-3
    )


# --- coroutines ----------------------------------------------------------------------------------


def test_a_task_runs_over_the_link_as_a_coroutine(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = ServerBench(wire)
    monkeypatch.setattr(
        "rfms_can.coordinator.connection.AsyncClientSocket",
        lambda *_: AsyncCoreSocket(CoreSocket(bench, b"program")),
    )

    async def main() -> Report:
        async with connect_async("bench", name="cell", lease_s=10.0) as arm:
            hand = Frame("hand", Transform.identity())
            place = Frame("place", Transform.translation(0.0, 0.0, 0.03) @ arm.pose)
            task = approach(hand, place, by=(0.0, 0.0, -0.02), speed=0.05)
            await task.run_async(arm)
            report = await task.run_async(arm)
            with pytest.raises(ProgramError, match="task/hand"):
                await arm.remove("task/hand")
            return report

    report = asyncio.run(main())
    assert [(one.sequence, one.how) for one in report.outcomes] == [
        (3, Outcome.MADE),
        (4, Outcome.MADE),
    ]
