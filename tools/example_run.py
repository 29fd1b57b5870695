"""The example programs on the simulated bus, and what the arm did in every cycle of them."""

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from rfms_can.arm import arm_by_name
from rfms_can.coordinator import Arm
from rfms_can.kinematics import Joints, direct
from rfms_can.master.phases import Phase
from rfms_can.master.report import status_of
from rfms_can.messages import Status
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame

Array = npt.NDArray[np.float64]

Truth = Callable[[float], Transform]
Picture = Callable[[Truth, float], Transform]
"""What a camera makes of where the part truly is, at the time of the picture."""

EXAMPLES = Path(__file__).parents[1] / "examples"
TOOL = Transform.translation(0.0, 0.0, 0.1354)
"""The tool of the examples."""


def example(name: str, **constants: object) -> ModuleType:
    """An example as a module, some of its constants changed."""
    path: Path = EXAMPLES / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"example_{name}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for constant, value in constants.items():
        assert hasattr(module, constant)
        setattr(module, constant, value)
    return module


@dataclass
class Trace:
    """A run, cycle by cycle.

    Attributes:
        rig: the nodes: what a test may ask or do while the program runs.
        statuses: of every cycle; its joints are those measured at the SYNC at its time.
        commanded: joint set-points of the same cycles, rad.
        stages, sequences: of the trajectory generator, when it made them, and the moves it made.
        on_cycle: called after every cycle: what the world around the arm does.
    """

    settings: RunSettings
    rig: SimulatedRig
    statuses: list[Status] = field(default_factory=list)
    commanded: list[Joints] = field(default_factory=list)
    stages: list[str] = field(default_factory=list)
    sequences: list[int] = field(default_factory=list)
    on_cycle: Callable[["Trace"], None] | None = None

    @property
    def times(self) -> Array:
        """The server's time, s (n)."""
        return np.array([status.time for status in self.statuses])

    def measured_tools(self, tool: Transform = TOOL) -> Array:
        """Origin of the tool by the encoders, m (n, 3)."""
        return self._tools((status.joints for status in self.statuses), tool)

    def commanded_tools(self, tool: Transform = TOOL) -> Array:
        """Origin of the tool by the joint set-points, m (n, 3)."""
        return self._tools(self.commanded[: len(self.statuses)], tool)

    def _tools(self, joints: Any, tool: Transform) -> Array:
        arm = arm_by_name(self.settings.arm)
        return np.array([origin(direct(arm, q) @ tool) for q in joints])

    def arrival(self, sequence: int) -> int:
        """Index of the first cycle in which a move is complete."""
        return next(i for i, s in enumerate(self.statuses) if s.completed >= sequence)

    def take(self, _: int, frame: Frame) -> None:
        """At a SYNC the cycle before it is closed, and the set-point of its own is made."""
        master = self.rig.master
        if frame.id != _SYNC or master.phase is not Phase.RUN:
            return
        motion = master.motion
        if self.commanded:  # the first SYNC closes no cycle of the run
            self.statuses.append(status_of(master))
            if self.on_cycle is not None:
                self.on_cycle(self)
        self.commanded.append(motion.commanded.theta)
        self.stages.append(motion.generator.stage.name)
        self.sequences.append(motion.generator.sequence)


_SYNC = Wire().codecs["SYNC"].id


def trace(
    program: Callable[[Arm], None],
    settings: RunSettings,
    on_cycle: Callable[[Trace], None] | None = None,
) -> Trace:
    """Run a program on the simulated bus, well to its end."""
    traces: list[Trace] = []

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        traces.append(Trace(settings, rig, on_cycle=on_cycle))
        rig.observe(traces[0].take)

    outcome = execute(program, settings, watch=watch)
    assert outcome.fault is None, outcome.fault
    assert outcome.result.incomplete == 0
    return traces[0]


def run_example(
    name: str,
    arm: str = "puma260",
    friction: str = "corke",
    on_cycle: Callable[[Trace], None] | None = None,
    law: str = "weighted",
    **constants: object,
) -> Trace:
    """An example on the simulated bus."""
    module = example(name, **constants)
    return trace(module.program, RunSettings(arm=arm, friction=friction, law=law), on_cycle)


def on_the_belt(
    module: ModuleType, arm: str, friction: str, picture: Picture | None = None
) -> tuple[Trace, Any]:
    """The conveyor's run, and the belt that was in it, seen by a camera of one's own if given."""
    belts: list[Any] = []
    known = module.Belt

    def belt(*arguments: Any) -> Any:
        made = known(*arguments)
        belts.append(made)
        if picture is not None:
            made.picture = partial(picture, made.part)
        return made

    setattr(module, "Belt", belt)  # noqa: B010
    run = trace(module.program, RunSettings(arm=arm, friction=friction))
    return run, belts[0]


def origin(pose: Transform) -> tuple[float, float, float]:
    """Where a frame is, m."""
    return pose.px, pose.py, pose.pz
