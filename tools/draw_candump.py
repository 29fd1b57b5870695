"""Write two cycles of joint 5 into the README: as candump shows them, and one of them decoded."""

import subprocess
import sys
from collections.abc import Sequence

from generated import DOCS, main

from rfms_can.rig.program import load_program
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Dac, JointError, Measure, Sync

ROOT = DOCS.parent
CYCLES = (718, 719)
JOINT = 5


def frames() -> list[Frame]:
    """The frames of these cycles that concern the joint, from a run of the transfer."""
    wire = Wire()
    sync = wire.codec(Sync)
    wanted = {sync.id, *(wire.id(record, JOINT) for record in (Measure, JointError, Dac))}
    found: list[Frame] = []
    cycle = 0

    def look(_: int, frame: Frame) -> None:
        nonlocal cycle
        if frame.id == sync.id:
            values = sync.unpack(frame.data)
            assert values is not None
            cycle = values.cycle
        if cycle in CYCLES and frame.id in wanted:
            found.append(frame)

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        rig.observe(look)

    execute(load_program(ROOT / "examples" / "transfer.py"), RunSettings(), watch=watch)
    return found


def as_candump(frame: Frame) -> str:
    """The line candump prints."""
    data = frame.data.hex(" ").upper()
    return f"  vcan0  {frame.id:03X}  [{len(frame.data):02d}]  {data}"


def decoded(lines: Sequence[str]) -> list[str]:
    """What cantools makes of the lines."""
    command = [sys.executable, "-m", "cantools", "decode", "--single-line", "dbc/rfms.dbc"]
    done = subprocess.run(
        command, cwd=ROOT, input="\n".join(lines), capture_output=True, text=True, check=True
    )
    return [line.partition(":: ")[2] for line in done.stdout.splitlines()]


def render() -> str:
    """Both blocks."""
    heard = frames()
    lines = [as_candump(frame) for frame in heard]
    masks = ",".join(f"{identifier:03X}:7FF" for identifier in dict.fromkeys(f.id for f in heard))
    return "\n".join(
        [
            f"Joint {JOINT} for two cycles of `examples/transfer.py` on `vcan0`: SYNC, what its "
            "board measured, its error, its answer.",
            "",
            "```console",
            f"$ candump vcan0,{masks}",
            *lines,
            "```",
            "",
            "The first of them once more through `cantools decode --single-line dbc/rfms.dbc`:",
            "",
            "```",
            *decoded(lines[: len(lines) // len(CYCLES)]),
            "```",
        ]
    )


if __name__ == "__main__":
    main("draw_candump.py", "../README.md", render)
