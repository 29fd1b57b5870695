"""``rfms demo``: the thesis' kind of program on the PUMA 260, over the simulated bus."""

from importlib import resources
from pathlib import Path

from rfms_can.cli.options import JsonOption, RecordOption
from rfms_can.cli.run import run_program
from rfms_can.errors import ProgramError
from rfms_can.rig.settings import RunSettings

DEMO = "peg_in_hole.py"


def demo(record: RecordOption = None, as_json: JsonOption = False) -> None:
    """Carry a part from one place to another: joint and Cartesian segments, and the gripper."""
    run_program(demo_program(), RunSettings(), record=record, as_json=as_json)


def demo_program() -> Path:
    """The demo's program: in the installed package, or in the source tree's ``examples/``."""
    package = Path(str(resources.files("rfms_can")))
    for path in (package / "examples" / DEMO, package.parent / "examples" / DEMO):
        if path.is_file():
            return path
    raise ProgramError(f"{DEMO} is neither in {package} nor in {package.parent}; reinstall")
