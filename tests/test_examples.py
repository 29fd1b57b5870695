"""Every example does what it is about, on the simulated bus; the numbers are those of the arm.

The joints are those the encoders told, the poses what direct kinematics makes of them.
"""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from example_run import Array, Trace, example, origin, run_example

from rfms_can.arm import arm_by_name
from rfms_can.errors import MoveError
from rfms_can.transform import Transform

pytestmark = pytest.mark.system

ARMS = ("puma260", "puma560")

run = cache(run_example)
"""One run for all tests that look at it."""


def hand(trace: Trace) -> Transform:
    """Where the hand was when the arm was enabled, to a count of the encoders."""
    return Transform(*trace.statuses[0].t6)


def bench(trace: Trace, below: float) -> Transform:
    """The bench of an example, so far below the hand."""
    pose = hand(trace)
    return Transform.translation(pose.px, pose.py, pose.pz - below)


def rests(trace: Trace) -> list[int]:
    """The last cycle of every rest."""
    rest = [status.at_rest for status in trace.statuses]
    return [i for i in range(len(rest)) if rest[i] and (i + 1 == len(rest) or not rest[i + 1])]


def millimetres(distance: float) -> str:
    return f"{1e3 * distance:.3f} mm"


# --- the thesis' program -------------------------------------------------------------------------


def peg_tips(trace: Trace) -> Array:
    """The tip of the peg over the floor: z t6 e."""
    tips = trace.measured_tools(Transform.translation(0.0, 0.0, 0.2))
    tips[:, 2] += 0.864
    return tips


def test_the_thesis_peg_goes_to_the_printed_numbers_and_straight_down() -> None:
    """With pure position control: in the air nothing leads a peg that complies."""
    trace = run("thesis_peg", "puma560", law="position")
    tips = peg_tips(trace)
    there = [trace.arrival(sequence) for sequence in (1, 2)]
    for cycle, place in zip(there, ((0.6, 0.25, 0.7), (0.6, 0.25, 0.5)), strict=True):
        off = float(np.linalg.norm(tips[cycle] - place))
        print(f"peg at {place}: off by {millimetres(off)}")
        assert off < 0.3e-3
    way = tips[there[0] : there[1]]
    aside = float(np.hypot(way[:, 0] - 0.6, way[:, 1] - 0.25).max())
    print(f"on the way down at most {millimetres(aside)} aside")
    assert way[:, 2].min() < 0.501
    assert aside < 0.3e-3


def test_the_thesis_peg_complies_on_the_way_down_only() -> None:
    trace = run("thesis_peg", "puma560")
    words = [status.comply for status in trace.statuses]
    assert set(words) == {"", "fx fy rx ry"}
    complying = [i for i, word in enumerate(words) if word]
    assert complying == list(range(complying[0], complying[-1] + 1))
    assert complying[0] - trace.arrival(1) in (0, 1)
    assert complying[-1] - trace.arrival(2) in (-1, 0)


def test_the_thesis_peg_is_let_go_at_the_bottom() -> None:
    trace = run("thesis_peg", "puma560")
    bottom = trace.arrival(2)
    assert trace.statuses[bottom].jaw < 0.001
    assert trace.statuses[-1].jaw > 0.079
    moving = [i for i, s in enumerate(trace.statuses) if s.sequence == 3]
    assert trace.statuses[moving[0]].jaw > 0.079


def test_the_thesis_peg_is_out_of_reach_of_a_260_before_anything_moves() -> None:
    kept: list[Trace] = []
    with pytest.raises(MoveError, match=r"hole.*puma260.*reach is 0\.4064 m"):
        run_example("thesis_peg", "puma260", on_cycle=kept.append)
    assert not any(rate for rate in kept[0].rig.master.motion.commanded.rate)
    assert all(status.stage == "IDLE" for status in kept[0].statuses)


# --- pick and place ------------------------------------------------------------------------------


def a_part_lies_there(trace: Trace) -> None:
    """Between the fingers from the moment the tool is at the part."""
    jaw = trace.rig.plant.physics.jaw
    if trace.statuses[-1].completed == 2 and jaw.part_width == 0.0:
        jaw.put_part(0.03)


@pytest.mark.parametrize("arm", ARMS)
def test_a_part_is_picked_and_placed(arm: str) -> None:
    trace = run_example("pick_and_place", arm, on_cycle=a_part_lies_there)
    tools, statuses = trace.measured_tools(), trace.statuses
    corner = np.array(origin(bench(trace, 0.24)))
    at_part, at_goal = trace.arrival(2), trace.arrival(5)
    for cycle, place in ((at_part, (0.02, 0.16, 0.02)), (at_goal, (0.05, -0.06, 0.02))):
        off = float(np.linalg.norm(tools[cycle] - corner - place))
        print(f"{arm} at {place}: off by {millimetres(off)}")
        assert off < 0.3e-3
    carried = [s.jaw for s in statuses if 3 <= s.sequence <= 4]
    assert max(carried) == pytest.approx(0.03, abs=2e-5)
    assert min(carried) == pytest.approx(0.03, abs=2e-5)
    assert statuses[-1].jaw == pytest.approx(0.08, abs=2e-5)
    lift = tools[at_part : at_goal + 1, 2] - corner[2]
    assert lift.max() > 0.075


def test_without_a_part_nothing_is_carried(capsys: pytest.CaptureFixture[str]) -> None:
    trace = run_example("pick_and_place")
    assert "no part: the jaw stands at 0.0 mm" in capsys.readouterr().out
    goal_side = trace.measured_tools()[:, 1] - hand(trace).py
    assert goal_side.min() > -0.03
    assert trace.statuses[-1].completed == 4


# --- palletising ---------------------------------------------------------------------------------


@pytest.mark.parametrize("arm", ARMS)
def test_every_place_of_the_pallet_is_filled(arm: str) -> None:
    """The tool rests at each of the six places, within two counts of every encoder."""
    trace, module = run("palletising", arm), example("palletising")
    places = {
        (i, j): bench(trace, 0.24) @ module.pallet_on_bench() @ module.place_on_pallet(i, j)
        for i in range(module.COLUMNS)
        for j in range(module.ROWS)
    }
    assert len(places) == 6
    tools = trace.measured_tools()
    resting = rests(trace)
    drives = arm_by_name(arm).drives
    worst_counts = worst = 0.0
    for place in places.values():
        target = np.array(origin(place))
        cycle = min(resting, key=lambda i: float(np.linalg.norm(tools[i] - target)))
        worst = max(worst, float(np.linalg.norm(tools[cycle] - target)))
        resting.remove(cycle)
        errors = trace.statuses[cycle].errors
        worst_counts = max(
            worst_counts,
            *(abs(e * d.counts_per_radian) for e, d in zip(errors, drives, strict=True)),
        )
    print(f"{arm}: places off by {millimetres(worst)}, joints by {worst_counts:.2f} counts")
    assert worst < 0.2e-3
    assert worst_counts <= 2.0


def test_segments_take_as_long_as_their_speeds_ask() -> None:
    """The approach to the feeder cruises at 0.12 m/s; nothing is faster than 0.4 m/s."""
    trace = run("palletising", "puma560")
    steps = np.linalg.norm(np.diff(trace.commanded_tools(), axis=0), axis=1) * 250.0
    near = [
        i
        for i in range(len(trace.statuses) - 1)
        if trace.sequences[i] == 2 and trace.stages[i] == trace.stages[i + 1] == "LINEAR"
    ]
    assert near
    assert steps[near] == pytest.approx(0.12, rel=0.03)
    print(f"fastest {steps.max():.3f} m/s")
    assert steps.max() < 0.45


# --- weave ---------------------------------------------------------------------------------------


def seam_cycles(trace: Trace, sequence: int) -> list[int]:
    """Cycles in which a move ran straight."""
    return [
        i
        for i in range(len(trace.statuses))
        if trace.sequences[i] == sequence and trace.stages[i] == "LINEAR"
    ]


@pytest.mark.parametrize("arm", ARMS)
def test_the_tool_weaves_with_amplitude_and_pitch(arm: str) -> None:
    """A sine of the pitch fits the way across each segment to a few per cent of its amplitude."""
    trace, module = run("weave", arm), example("weave")
    tools = trace.measured_tools()
    corner = np.array(origin(bench(trace, 0.22)))
    for number, (one, other) in enumerate(pairwise(module.SEAM), 1):
        cycles = seam_cycles(trace, 2 + number)
        assert len(cycles) > 250
        along = (np.array(other) - one) / np.linalg.norm(np.array(other) - one)
        side = np.array([-along[1], along[0], 0.0])
        way = tools[cycles] - corner - one
        s, across = way @ along, way @ side
        angle = 2.0 * np.pi * s / module.PITCH
        basis = np.column_stack([np.sin(angle), np.cos(angle), np.ones_like(angle)])
        (amplitude, quadrature, offset), *_ = np.linalg.lstsq(basis, across, rcond=None)
        rest = across - basis @ (amplitude, quadrature, offset)
        speed = float(np.polyfit(trace.times[cycles], s, 1)[0])
        print(
            f"{arm} segment {number}: {millimetres(amplitude)} at {speed / module.PITCH:.3f} Hz, "
            f"rest {millimetres(float(np.std(rest)))} rms"
        )
        assert amplitude == pytest.approx(module.AMPLITUDE, rel=0.05)
        assert abs(quadrature) < 0.1 * module.AMPLITUDE
        assert abs(offset) < 0.05 * module.AMPLITUDE
        assert float(np.std(rest)) < 0.05 * module.AMPLITUDE
        assert speed == pytest.approx(module.SPEED, rel=0.02)


@pytest.mark.parametrize("arm", ARMS)
def test_the_corners_of_the_seam_are_kept(arm: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The tool passes each corner as near as the server has said, and it is near."""
    trace, module = run_example("weave", arm), example("weave")
    said = [float(line.split()[4]) * 1e-3 for line in capsys.readouterr().out.splitlines()]
    tools = trace.measured_tools()
    zero = np.array(origin(bench(trace, 0.22)))
    corners = module.SEAM[1:-1]
    assert len(said) == len(corners)
    for number, (corner, deviation) in enumerate(zip(corners, said, strict=True)):
        during = [i for i, s in enumerate(trace.statuses) if 3 + number <= s.sequence <= 5]
        nearest = float(np.linalg.norm(tools[during] - zero - corner, axis=1).min())
        print(f"{arm} corner: passed at {millimetres(nearest)}, said {millimetres(deviation)}")
        assert nearest == pytest.approx(deviation, abs=0.2e-3)
        assert deviation < 1e-3
