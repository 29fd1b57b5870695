"""``rfms demo``: the peg in the hole on the PUMA 560, on the simulated bus (thesis Fig. 1.1)."""

from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from rfms_can.cli.options import JsonOption, RecordOption
from rfms_can.cli.report import print_rows
from rfms_can.cli.run import run_program
from rfms_can.errors import ProgramError, RfmsError
from rfms_can.rig.settings import RunSettings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rfms_can.analysis.peg_figures import PegFigures
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
"""The hole is 0.86 mm from its nominal position and tilted by 0.4 degrees; the arm has the thesis'
friction, 14 N m in joint 1, which is 23 N at the hole."""
CONTROL: Final = f"law {SETTINGS.law}, 30 rad/s critically damped, dither {SETTINGS.dither:g}"
PICTURE: Final = Path("rfms-demo.png")


def demo(
    record: RecordOption = None,
    picture: Annotated[Path, typer.Option(help="of the insertion; needs matplotlib")] = PICTURE,
    as_json: JsonOption = False,
) -> None:
    """Insert a peg into a hole whose position the program does not know exactly; retract it."""
    from rfms_can.rig.simulated import SimulatedRig

    rigs: list[SimulatedRig] = []

    def watch(rig: "Rig") -> None:
        assert isinstance(rig, SimulatedRig) and rig.watch is not None
        rig.watch.keep_every_cycle()
        rigs.append(rig)

    def more() -> dict[str, Any]:
        """Further keys of the JSON object."""
        assert rigs[0].watch is not None
        rows = rigs[0].watch.rows
        drawn = _drawn(rows, picture)
        depth, lateral_peak, lateral_mean, axial_peak, *_ = _figures(rows)
        return {
            "peg": {
                "depth": depth,
                "lateral_peak": lateral_peak,
                "lateral_mean": lateral_mean,
                "axial_peak": axial_peak,
                "seconds": _seconds(rows),
            },
            "picture": str(drawn) if isinstance(drawn, Path) else None,
        }

    run_program(demo_program(), SETTINGS, record=record, as_json=as_json, watch=watch, more=more)
    if not as_json:
        assert rigs[0].watch is not None
        _print_insertion(rigs[0].watch.rows, picture)


def _print_insertion(rows: "Sequence[Truth]", picture: Path) -> None:
    """Print the numbers of the insertion and draw its picture."""
    figures, drawn = _figures(rows), _drawn(rows, picture)
    deep = f"{1e3 * figures.depth:.1f} mm deep, {_seconds(rows):.2f} s after it met the hole"
    across = f"{figures.lateral_peak:.1f} N across at most, {figures.lateral_mean:.1f} on average"
    print_rows(
        [
            ("peg", deep),
            ("", across),
            ("contact", "steel on steel: 1e7 N/m, friction 0.2, clearance 0.2 mm all round"),
            ("control", CONTROL),
            ("picture", str(drawn) if isinstance(drawn, Path) else f"none: {drawn}"),
        ]
    )


def _figures(rows: "Sequence[Truth]") -> "PegFigures":
    from rfms_can.analysis.peg_figures import peg_figures

    return peg_figures(rows)


def _seconds(rows: "Sequence[Truth]") -> float:
    """Time from the first contact until the peg was inserted, s."""
    return _figures(rows).cycles / SETTINGS.rate


def _drawn(rows: "Sequence[Truth]", picture: Path) -> Path | RfmsError:
    """The picture, or the error that prevented it."""
    try:
        from rfms_can.analysis.peg_picture import draw

        return draw(rows, 1.0 / SETTINGS.rate, f"{SETTINGS.scene} · {CONTROL}", picture)
    except RfmsError as error:
        return error


def demo_program() -> Path:
    """The demo's program: in the installed package, or in the source tree's ``examples/``."""
    package = Path(str(resources.files("rfms_can")))
    for path in (package / "examples" / DEMO, package.parent / "examples" / DEMO):
        if path.is_file():
            return path
    raise ProgramError(f"{DEMO} is neither in {package} nor in {package.parent}; reinstall")
