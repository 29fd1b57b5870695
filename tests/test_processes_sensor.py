"""A camera in a process of its own, beside the process of the coordinator: the conveyor's part."""

import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from example_run import EXAMPLES, Array, Trace, example, on_the_belt, origin
from support.command_line import MAIN

from rfms_can.rig.serve import Listening, serve
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.transform import Transform

pytestmark = pytest.mark.processes

CONVEYOR = EXAMPLES / "conveyor.py"
LONG_S = 120.0
THERE = 3
"""Number of the move to the part."""


class Served:
    """A server in a thread, and what its arm did in every cycle."""

    def __init__(self, settings: RunSettings) -> None:
        self.traces: list[Trace] = []
        self.events: list[str] = []
        self._settings = settings
        self._stop, self._ready = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()
        assert self._ready.wait(LONG_S)

    def _serve(self) -> None:
        def watch(rig: Rig) -> None:
            assert isinstance(rig, SimulatedRig)
            self.traces.append(Trace(self._settings, rig))
            rig.observe(self.traces[0].take)

        serve(
            self._settings,
            Listening("belt"),
            watch=watch,
            ready=self._ready.set,
            shown=lambda serving: self.events.extend(serving.server.events),
            interrupted=self._stop.is_set,
            grants={"camera": ["part"]},
        )

    def end(self) -> Trace:
        """The run, when the server has ended."""
        self._stop.set()
        self._thread.join(LONG_S)
        assert not self._thread.is_alive()
        return self.traces[0]


def errors(run: Trace, belt: Any, ride_s: float) -> Array:
    """Tool less part while the tool rides along, m (n, 3)."""
    arrived = run.statuses[run.arrival(THERE)].time
    cycles = [i for i, s in enumerate(run.statuses) if arrived <= s.time < arrived + ride_s]
    assert len(cycles) > 90
    parts = [origin(belt.part(run.statuses[i].time)) for i in cycles]
    found: Array = run.measured_tools()[cycles] - np.array(parts)
    return found


def test_the_part_is_tracked_as_in_one_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    module = example("conveyor")
    together, belt = on_the_belt(module, "puma260", "corke")
    expected = errors(together, belt, module.RIDE)

    server = Served(RunSettings(arm="puma260", friction="corke"))
    commands = (
        [sys.executable, str(CONVEYOR), "belt"],
        [sys.executable, "-c", MAIN, "coordinate", str(CONVEYOR), "--server", "belt", "--json"],
    )
    programs = [
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        for command in commands
    ]
    try:
        said = [program.communicate(timeout=LONG_S)[0] for program in programs]
    finally:
        for program in programs:
            program.kill()
        apart = server.end()
    assert [program.returncode for program in programs] == [0, 0], said
    assert "no coordinator controls the arm" in said[0]
    hand = Transform(*apart.statuses[0].t6)
    found = errors(apart, module.Belt(hand, module.SPEED, module.FIRST), module.RIDE)
    rms = [1e3 * float(np.sqrt(np.mean(np.sum(e**2, axis=1)))) for e in (expected, found)]
    print(f"tool error: {rms[0]:.4f} mm rms in one process, {rms[1]:.4f} mm in three")
    assert rms[1] == pytest.approx(rms[0], rel=0.02, abs=1e-3)
