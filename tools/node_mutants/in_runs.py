"""A mutant as one joint of a simulated run: where the arm was, and what the master made of it.

The arm truly is where the plant has it; the master commands joint angles. A node that raises is a
process that has died: it is silent from then on.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from node_mutants.apart import apart
from node_mutants.loading import MakeJoint, joint_of
from node_mutants.mutant import Mutant
from rfms_can.errors import RfmsError
from rfms_can.master.phases import Phase
from rfms_can.node.protocol import NOTHING
from rfms_can.rig import simulated
from rfms_can.rig.nodes import make_joint
from rfms_can.rig.program import load_program
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Sync

PROGRAM: Final = Path(__file__).with_name("motion.py")
SETTINGS: Final = "tools/node_mutants/motion.py, puma260, bus sim, 250 Hz, weighted law"
WRONG_RAD: Final = 0.035
"""2 degrees: a joint that was farther from where the master had it has moved wrongly."""
CPU_S: Final = 120
"""Processor time after which a run has hung; one takes 15 s."""

FINISHED: Final = "finished"
NAMED: Final = "stopped, named"
UNNAMED: Final = "stopped, not named"
BEFORE: Final = "not enabled"
HUNG: Final = "hung"


class Ended(NamedTuple):
    """How a run has ended.

    Attributes:
        worst: farthest that a joint was from where the master had it, rad, up to the stop.
        how: ``FINISHED``; ``NAMED`` or ``UNNAMED`` where the master stopped the arm; ``BEFORE``
            where it was never enabled; ``HUNG``.
        told: why it was stopped.
    """

    worst: float
    how: str
    told: str = ""


class Mortal:
    """A node whose exceptions end it, as they end its process."""

    echo = False

    def __init__(self, node: Any) -> None:
        self._node = node
        self._dead = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._node, name)

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        """Receive a frame, while alive."""
        if self._dead:
            return NOTHING
        try:
            return list(self._node.on_frame(frame, now_ns))
        except Exception:  # whatever a mutant raises
            return self._die()

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Handle deadlines, while alive."""
        try:
            return list(self._node.on_time(now_ns))
        except Exception:  # whatever a mutant raises
            return self._die()

    def next_deadline_ns(self) -> int | None:
        """None once dead."""
        return None if self._dead else self._node.next_deadline_ns()

    def _die(self) -> Sequence[Frame]:
        self._dead = True
        return NOTHING


class _Watch:
    """Where the arm is, against where the master has it, at each SYNC of the run."""

    def __init__(self, rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        self._rig = rig
        self._sync = rig.master.wire.id(Sync)
        self.worst = 0.0
        self.enabled = False
        rig.observe(self._look)

    def _look(self, _time_ns: int, frame: Frame) -> None:
        master = self._rig.master
        if frame.id == self._sync and master.phase is Phase.RUN:
            self.enabled = True
            truth, goals = self._rig.plant.physics.model.q, master.motion.commanded.theta
            off = max(abs(a - b) for a, b in zip(truth, goals, strict=True))
            self.worst = max(self.worst, off)


def run(mutant: Mutant | None, joint: int) -> Ended:
    """A run with a mutant in the place of a joint, in this process, whose rigs stay changed."""
    try:
        make = joint_of(mutant)
    except Exception as error:  # whatever a mutant raises where it is imported
        return Ended(0.0, BEFORE, f"not imported: {type(error).__name__}: {error}"[:200])

    def made(number: int, settings: RunSettings, wire: Wire) -> Any:
        if number != joint:
            return make_joint(number, settings, wire)
        return _born(make, number, settings)

    setattr(simulated, "make_joint", made)  # noqa: B010
    watches: list[_Watch] = []
    try:
        outcome = execute(
            load_program(PROGRAM), RunSettings(), watch=lambda rig: watches.append(_Watch(rig))
        )
        fault = "" if outcome.fault is None else str(outcome.fault)
    except RfmsError as error:
        fault = str(error)
    return _judged(watches, fault, joint)


def _born(make: MakeJoint, number: int, settings: RunSettings) -> Any:
    try:
        return Mortal(make(number, settings.boot_id(number)))
    except Exception:  # the process ends as it begins: a node that never says anything
        dead = Mortal(make_joint(number, settings, Wire()))
        dead._dead = True
        return dead


def _judged(watches: Sequence[_Watch], fault: str, joint: int) -> Ended:
    worst = max((watch.worst for watch in watches), default=0.0)
    told = fault.replace("\n", " ")[:200]
    if not fault:
        return Ended(worst, FINISHED)
    if not any(watch.enabled for watch in watches):
        return Ended(worst, BEFORE, told)
    return Ended(worst, NAMED if re.search(rf"\bjoint {joint}\b", told) else UNNAMED, told)


def run_of(mutant: Mutant | None, joint: int) -> Ended:
    """The same in a process of its own."""
    return apart(lambda: run(mutant, joint), CPU_S) or Ended(0.0, HUNG)
