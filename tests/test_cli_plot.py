"""``rfms plot``: from a recorded run to pictures, and one clear line without a recording."""

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner, Result

from rfms_can.analysis.canvas import PlotError, Sheet
from rfms_can.analysis.motions import thesis_motions
from rfms_can.analysis.plots import (
    QUANTITIES,
    TERM_COLORS,
    TERM_PANELS,
    Quantity,
    bus_sheet,
    joint_sheet,
    joint_terms_sheet,
    overview,
    quantity_sheet,
    terms_sheet,
)
from rfms_can.analysis.recording import Recording, RecordingError, load_recording
from rfms_can.analysis.thesis_figures import thesis_sheets
from rfms_can.cli.plot import plot
from rfms_can.joint_nodes.servo import ServoTerms
from rfms_can.rig.program import load_program
from rfms_can.rig.runner import execute
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.torque_terms import TERMS
from rfms_can.wire.contract import Wire

pytestmark = pytest.mark.system

RUN = ["run", *(quantity.name for quantity in QUANTITIES), "bus_load"]
THESIS = ["fig_3_3", "fig_3_4", "fig_3_5"]
MAGIC = {"png": b"\x89PNG\r\n", "svg": b"<?xml", "pdf": b"%PDF-"}
Run = Callable[..., Result]


@pytest.fixture(scope="module")
def recording(recorded: Path, wire: Wire) -> Recording:
    return load_recording(recorded, wire)


@pytest.fixture
def rfms_plot() -> Run:
    app = typer.Typer()
    app.command()(plot)
    return lambda *arguments: CliRunner().invoke(app, [str(word) for word in arguments])


def _words(sheet: Sheet) -> str:
    return " ".join(text.get_text() for text in sheet.figure.texts)


def names(directory: Path) -> list[str]:
    return sorted(path.stem for path in directory.iterdir())


def test_a_run_becomes_an_overview_and_a_sheet_per_quantity(
    rfms_plot: Run, recorded: Path, tmp_path: Path
) -> None:
    result = rfms_plot(recorded, "--out", tmp_path / "new" / "plots")
    assert result.exit_code == 0, result.output
    assert names(tmp_path / "new" / "plots") == sorted(RUN)
    assert result.stdout.splitlines() == [str(tmp_path / "new/plots" / f"{n}.png") for n in RUN]


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_thesis_figures_come_in_every_format(
    rfms_plot: Run, recorded: Path, tmp_path: Path, suffix: str
) -> None:
    words = ("--figures", "thesis", "--format", suffix, "--out", tmp_path, "--json")
    result = rfms_plot(recorded, *words)
    assert result.exit_code == 0, result.output
    report = json.loads(result.stdout)
    assert report["figures"] == [str(tmp_path / f"{name}.{suffix}") for name in THESIS]
    assert report["refused"] == 0
    for figure in report["figures"]:
        assert Path(figure).read_bytes().startswith(MAGIC[suffix])


def test_one_joint_is_one_sheet(rfms_plot: Run, recorded: Path, tmp_path: Path) -> None:
    assert rfms_plot(recorded, "--joint", 3, "--out", tmp_path).exit_code == 0
    assert names(tmp_path) == ["joint_3"]
    assert rfms_plot(recorded, "--joint", 7, "--out", tmp_path).exit_code == 2


def test_the_overview_shows_six_joints_and_the_bound(recording: Recording) -> None:
    positions, errors, torques, load = overview(recording).panels
    assert (len(positions.lines), len(errors.lines), len(torques.lines)) == (12, 6, 8)
    assert [line.get_ydata()[0] for line in torques.lines[-2:]] == [-100.0, 100.0]
    assert load.lines[1].get_ydata()[0] == pytest.approx(100.0 * recording.bus_bound)
    assert load.get_ylim()[1] > 100.0 * recording.bus_bound


@pytest.mark.parametrize("quantity", QUANTITIES, ids=lambda quantity: quantity.name)
def test_every_quantity_has_a_title_a_unit_and_a_panel_a_joint(
    recording: Recording, quantity: Quantity
) -> None:
    sheet = quantity_sheet(recording, quantity)
    titles = [axes.get_title(loc="left") for axes in sheet.panels]
    assert titles == [f"joint {joint}" for joint in range(1, 7)]
    assert {axes.get_ylabel() for axes in sheet.panels} == {quantity.unit}
    assert sheet.figure.legends
    for joint, axes in enumerate(sheet.panels):
        shown = [trace for trace in quantity.traces(recording) if trace is not None]
        for line, trace in zip(axes.lines, shown, strict=False):
            assert np.array_equal(line.get_ydata(), trace.values[:, joint], equal_nan=True)


def test_joint_and_bus_sheets_stand_for_themselves(recording: Recording) -> None:
    sheet = joint_sheet(recording, 2)
    assert [axes.get_ylabel() for axes in sheet.panels] == [q.unit for q in QUANTITIES]
    limit = recording.arm.drives[1].torque_limit
    assert [line.get_ydata()[0] for line in sheet.panels[-1].lines[-2:]] == [-limit, limit]
    assert len(bus_sheet(recording).panels) == 1


def test_thesis_figures_show_the_three_motions_to_one_scale(recording: Recording) -> None:
    sheets = list(thesis_sheets(recording, 1))
    assert [number for number, _ in sheets] == ["3.3", "3.4", "3.5"]
    scales = [[axes.get_ylim() for axes in sheet.panels] for _, sheet in sheets]
    assert scales[0] == scales[1] == scales[2]
    assert all("continuous blend" in _words(sheet) for _, sheet in sheets)
    peaks = [
        [np.nanmax(np.abs(axes.lines[0].get_ydata())) for axes in sheet.panels]
        for _, sheet in sheets
    ]
    assert peaks[1][2] < 0.6 * peaks[0][2]  # twice the t_acc: half the acceleration,
    assert peaks[1][3] < 0.35 * peaks[0][3]  # a quarter of the jerk
    for (_, sheet), motion in zip(sheets, thesis_motions(recording), strict=True):
        time, position = sheet.panels[0].lines[0].get_data()
        assert time[0] < 0.0 < time[-1] < 0.8  # with rest around it, and no other motion
        assert position[0] == pytest.approx(motion.places[0][0])
        assert position[-1] == pytest.approx(motion.places[1][0])


def test_between_transitions_only_joint_mode_runs_evenly(recording: Recording) -> None:
    """Fig. 3.5: in Cartesian mode velocity is not constant in joint space."""
    three, acceleration = thesis_motions(recording), recording.derivative(2)[:, 0]
    even = []
    for motion in (three.joint, three.cartesian):
        accelerate = round(2.0 * motion.acceleration_time / recording.period_s)
        rows = slice(motion.start + accelerate + 2, motion.stop - accelerate - 2)
        even.append(np.abs(acceleration[rows]).max())
    assert even[0] < 1e-3  # r and poses are float32: a rounding of r is 3e-4 rad/s2
    assert even[1] > 10.0 * even[0]


def test_every_term_of_a_torque_has_a_colour_and_a_panel() -> None:
    assert set(TERM_COLORS) == set(ServoTerms._fields)
    shown = [name for _, terms in TERM_PANELS for name in terms]
    assert sorted(shown) == sorted(ServoTerms._fields)


def test_recorded_terms_are_drawn_and_add_up_to_what_the_dac_was_told(
    rfms_plot: Run, recorded_with_terms: Path, tmp_path: Path, wire: Wire
) -> None:
    assert rfms_plot(recorded_with_terms, "--out", tmp_path / "all").exit_code == 0
    assert names(tmp_path / "all") == sorted([*RUN, "terms"])
    assert rfms_plot(recorded_with_terms, "--joint", 2, "--out", tmp_path / "one").exit_code == 0
    assert names(tmp_path / "one") == ["joint_2", "joint_2_terms"]
    recording = load_recording(recorded_with_terms, wire)
    assert recording.terms is not None
    for joint, terms in enumerate(recording.terms):
        row = np.searchsorted(recording.log.cycle, terms.cycle)
        code = abs(recording.arm.board_scale(joint).torque_per_dac_code)
        assert np.abs(terms.torque - recording.torque[row, joint]).max() < 0.51 * code
    panels = terms_sheet(recording, recording.terms).panels
    torque, *parts = panels[1].lines
    total = np.sum([line.get_ydata() for line in parts], axis=0)
    assert torque.get_ydata() == pytest.approx(total, abs=1e-9)
    titles = [
        p.get_title(loc="left") for p in joint_terms_sheet(recording, recording.terms[1], 2).panels
    ]
    assert titles == [title for title, _ in TERM_PANELS][: len(titles)]
    assert len(titles) == 2  # rigid: nothing of force control acted


@pytest.mark.parametrize("spoil", ["bytes", "names"])
def test_terms_that_cannot_be_read_are_one_clear_line(
    rfms_plot: Run, recorded: Path, tmp_path: Path, spoil: str
) -> None:
    copy = Path(shutil.copytree(recorded, tmp_path / "copy"))
    path = copy / TERMS
    if spoil == "bytes":
        path.write_bytes(b"no archive")
    else:
        tables = {f"joint_{joint}": np.zeros((1, 2)) for joint in range(1, 7)}
        np.savez(path, allow_pickle=False, terms=np.array(["p"]), **tables)
    result = rfms_plot(copy)
    assert isinstance(result.exception, RecordingError)
    assert TERMS in str(result.exception)


def test_a_directory_without_a_run_is_one_clear_line(rfms_plot: Run, tmp_path: Path) -> None:
    result = rfms_plot(tmp_path)
    assert isinstance(result.exception, RecordingError)
    assert "bus.log" in str(result.exception) and "--record" in str(result.exception)


def test_an_out_that_is_a_file_is_one_clear_line(
    rfms_plot: Run, recorded: Path, tmp_path: Path
) -> None:
    (tmp_path / "taken").write_text("")
    result = rfms_plot(recorded, "--out", tmp_path / "taken")
    assert isinstance(result.exception, PlotError)
    assert "cannot write" in str(result.exception)


def test_without_matplotlib_the_way_out_is_named(
    rfms_plot: Run, recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [n for n in sys.modules if n.startswith("rfms_can.analysis.")]:
        if name.rpartition(".")[2] in ("canvas", "plots", "thesis_figures"):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    result = rfms_plot(recorded, "--out", tmp_path)
    assert type(result.exception).__name__ == "PlotError"
    assert "pip install 'rfms_can[viz]'" in str(result.exception)
    assert names(tmp_path) == []


@pytest.mark.parametrize("arm", ["puma260", "puma560"])
def test_the_example_makes_the_three_motions_on_both_arms(
    arm: str, tmp_path: Path, wire: Wire
) -> None:
    program = load_program(Path(__file__).parents[1] / "examples" / "figures.py")
    assert execute(program, RunSettings(arm=arm), record=tmp_path).fault is None
    three = thesis_motions(load_recording(tmp_path, wire))
    assert [len(motion.moves) for motion in three] == [2, 2, 2]
