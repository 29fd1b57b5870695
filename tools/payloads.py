#!/usr/bin/env python3
"""The bus traffic of four runs: a digest of each, and its joint errors and DAC codes to compare.

A change of the code that does not change the wire leaves the digests unchanged: SHA-256 over the
identifiers and payloads of all frames from enable on, in the order of the bus, until the arm is
disabled. Where the wire itself changes, ``--save`` keeps ERROR and DAC as decoded values before
it, and ``--against`` compares them cycle by cycle after it.
"""

import argparse
import hashlib
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rfms_can.identification.experiments.actions import program_of
from rfms_can.identification.experiments.plan import experiments
from rfms_can.rig.program import load_program
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Program, Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, JOINTS
from rfms_can.wire.protection import Refusal
from rfms_can.wire.records import Dac, JointError, Sync
from rfms_can.wire.vocabulary import NodeState

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
EXPERIMENT = "burst-wrist"
"""One experiment of ``rfms identify``: wrist joints swing as fast as they can."""

Floats = npt.NDArray[np.float64]


@dataclass
class Listening:
    """Takes the frames of one run as they pass.

    Attributes:
        digest: over identifiers and payloads of the enabled cycles.
        frames: how many those are.
        errors: joint errors of each enabled cycle, rad; NaN where a joint told none.
        codes: current and force codes of each enabled cycle, all nodes with a board.
    """

    wire: Wire
    digest: Any = field(default_factory=hashlib.sha256)
    frames: int = 0
    errors: list[list[float]] = field(default_factory=list)
    codes: list[list[float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        wire = self.wire
        self._enabled = False
        self._sync = wire.id(Sync)
        self._decoders: dict[int, tuple[Any, int]] = {
            self._sync: (wire.receiver(Sync).decoder, 0),
            **{wire.id(JointError, n): (wire.receiver(JointError, n).decoder, n) for n in JOINTS},
            **{wire.id(Dac, n): (wire.receiver(Dac, n).decoder, n) for n in (*JOINTS, GRIPPER)},
        }

    def take(self, _time_ns: int, frame: Frame) -> None:
        """One frame of the bus."""
        if frame.id in self._decoders:
            decoder, node = self._decoders[frame.id]
            values = decoder.decode(frame)
            assert not isinstance(values, Refusal), frame
            self._note(values, node)
        if self._enabled:
            self.frames += 1
            self.digest.update(frame.id.to_bytes(2, "little") + frame.data)

    def _note(self, values: Any, node: int) -> None:
        if isinstance(values, Sync):
            self._enabled = values.state == NodeState.OPERATIONAL
            if self._enabled:
                self.errors.append([np.nan] * len(JOINTS))
                self.codes.append([np.nan] * (2 * (len(JOINTS) + 1)))
        elif not self._enabled:
            return
        elif isinstance(values, JointError):
            self.errors[-1][node - 1] = values.error
        else:
            self.codes[-1][2 * (node - 1) : 2 * node] = [values.current_dac, values.force_dac]


def runs() -> dict[str, tuple[Program, RunSettings]]:
    """The four runs: two arms; joint, straight, force-controlled and sensor-led motion."""
    puma560 = RunSettings(arm="puma560")
    peg = RunSettings(
        arm="puma560",
        scene="peg:x_mm=1,tilt_x_deg=0.5",
        friction="thesis",
        dither=0.9,
        sensor="good",
    )
    plan = {experiment.name: experiment for experiment in experiments(puma560.the_arm)}
    uncompensated = RunSettings(arm="puma560", dynamics="none", law="hybrid")
    probing = program_of(plan[EXPERIMENT].actions, puma560.the_arm, [])
    return {
        "transfer": (load_program(EXAMPLES / "transfer.py"), RunSettings()),
        "peg_in_hole": (load_program(EXAMPLES / "peg_in_hole.py"), peg),
        "conveyor": (load_program(EXAMPLES / "conveyor.py"), RunSettings()),
        f"identify {EXPERIMENT}": (probing, uncompensated),
    }


def listen(program: Program, settings: RunSettings) -> Listening:
    """Run a program on the simulated bus."""
    heard = Listening(Wire())

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        rig.observe(heard.take)

    outcome = execute(program, settings, watch=watch)
    if outcome.fault is not None:
        raise outcome.fault
    return heard


def compare(name: str, heard: Listening, kept: Callable[[str], Floats]) -> bool:
    """Print how far a run is from the kept one; whether errors are equal and codes within one."""
    errors, codes = np.array(heard.errors), np.array(heard.codes)
    before_errors, before_codes = kept(f"{name} errors"), kept(f"{name} codes")
    if errors.shape != before_errors.shape:
        print(f"  {name}: {len(errors)} cycles, {len(before_errors)} before")
        return False
    silent = bool(np.array_equal(np.isnan(errors), np.isnan(before_errors)))
    far = float(np.nanmax(np.abs(errors - before_errors)))
    steps = np.abs(codes - before_codes)
    off, cycles = float(np.nanmax(steps)), int(np.any(steps > 0.0, axis=1).sum())
    print(f"  errors within {far:.3g} rad, codes within {off:g}, {cycles} cycles with another code")
    return silent and far == 0.0 and off <= 1.0


def main() -> int:
    """Print the four digests; save or compare what was decoded."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--save", type=Path, help="keep errors and codes in this file (.npz)")
    parser.add_argument("--against", type=Path, help="compare with errors and codes kept before")
    parser.add_argument("--only", help="one run, by its name")
    options = parser.parse_args()
    kept = None if options.against is None else np.load(options.against)
    saved: dict[str, Floats] = {}
    same = True
    for name, (program, settings) in runs().items():
        if options.only not in (None, name):
            continue
        heard = listen(program, settings)
        print(f"{heard.digest.hexdigest()}  {name}, {heard.frames} frames", flush=True)
        saved[f"{name} errors"] = np.array(heard.errors)
        saved[f"{name} codes"] = np.array(heard.codes)
        if kept is not None:
            same &= compare(name, heard, kept.__getitem__)
    if options.save is not None:
        np.savez_compressed(options.save, allow_pickle=False, **saved)
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
