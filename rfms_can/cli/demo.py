"""``rfms demo``: the peg in the hole on the PUMA 560, on the simulated bus (thesis Fig. 1.1)."""

from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from rfms_can.cli.options import JsonOption, RecordOption
from rfms_can.cli.report import print_rows
from rfms_can.cli.run import run_program
from rfms_can.errors import ProgramError
from rfms_can.rig.settings import RunSettings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rfms_can.rig.session import Rig
    from rfms_can.rig.truth import Truth

DEMO: Final = "peg_in_hole.py"
SETTINGS: Final = RunSettings(
    arm="puma560",
    scene="peg:x_mm=0.7,y_mm=-0.5,tilt_x_deg=0.4",
    friction="thesis",
    dither=0.9,
    sensor="good",
)
"""The hole is 0.86 mm beside where the program has it and leans by 0.4 degrees; the arm has the
thesis' friction, 14 N m in joint 1, which is 23 N at the hole."""
PICTURE: Final = Path("rfms-demo.png")


def demo(
    record: RecordOption = None,
    picture: Annotated[Path, typer.Option(help="of the insertion; needs matplotlib")] = PICTURE,
    as_json: JsonOption = False,
) -> None:
    """Put a peg into a hole that is not where the program has it, and take it out again."""
    from rfms_can.rig.simulated import SimulatedRig

    rigs: list[SimulatedRig] = []

    def watch(rig: "Rig") -> None:
        assert isinstance(rig, SimulatedRig) and rig.watch is not None
        rig.watch.keep = True
        rigs.append(rig)

    run_program(demo_program(), SETTINGS, record=record, as_json=as_json, watch=watch)
    (rig,) = rigs
    assert rig.watch is not None
    if not as_json:
        _tell(rig.watch.rows, 1.0 / SETTINGS.rate, picture)


def _tell(rows: "Sequence[Truth]", period_s: float, picture: Path) -> None:
    """The numbers of the insertion, and its picture."""
    from rfms_can.analysis.peg_figures import peg_figures
    from rfms_can.errors import RfmsError

    figures = peg_figures(rows, 0.039)
    seconds = figures.cycles * period_s
    words = f"law {SETTINGS.law}, 30 rad/s critically damped, dither {SETTINGS.dither:g}"
    told = [
        ("peg", f"{1e3 * figures.depth:.1f} mm deep, {seconds:.2f} s after it met the hole"),
        ("", f"{figures.lateral_peak:.1f} N across at most, {figures.lateral_mean:.1f} on average"),
        ("contact", "steel on steel: 1e7 N/m, friction 0.2, clearance 0.2 mm all round"),
        ("control", words),
    ]
    try:
        from rfms_can.analysis.peg_picture import draw

        told.append(("picture", str(draw(rows, period_s, f"{SETTINGS.scene} · {words}", picture))))
    except RfmsError as error:
        told.append(("picture", f"none: {error}"))
    print_rows(told)


def demo_program() -> Path:
    """The demo's program: in the installed package, or in the source tree's ``examples/``."""
    package = Path(str(resources.files("rfms_can")))
    for path in (package / "examples" / DEMO, package.parent / "examples" / DEMO):
        if path.is_file():
            return path
    raise ProgramError(f"{DEMO} is neither in {package} nor in {package.parent}; reinstall")
