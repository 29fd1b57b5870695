"""Runs in a scene for tests: what truly happened in every cycle, beside what the server told."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.master.report import status_of
from rfms_can.messages import Status
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Program, Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.rig.truth import Truth
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame

Array = npt.NDArray[np.float64]

PERIOD_S = 0.004
_SYNC = Wire().codecs["SYNC"].id


class Moment(NamedTuple):
    """One cycle.

    Attributes:
        truth: what the plant knows; forces are means of the period before.
        status: what the server told.
        torques: what the joints had asked of their motors, Nm (6).
    """

    truth: Truth
    status: Status
    torques: list[float]

    @property
    def words(self) -> str:
        """Directions it complied in."""
        return self.status.complying


Run = Sequence[Moment]


def run(program: Program, scene: str, friction: str = "thesis", **settings: Any) -> list[Moment]:
    """A program in a scene on the simulated bus; the arm has the thesis' friction."""
    told: list[tuple[Status, list[float]]] = []
    rigs: list[SimulatedRig] = []

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig) and rig.watch is not None
        rig.watch.keep = True
        rigs.append(rig)

        def look(_: int, frame: Frame) -> None:
            if frame.id == _SYNC:
                told.append((status_of(rig.master), [joint.torque for joint in rig.joints]))

        rig.observe(look)

    made = RunSettings(arm="puma560", scene=scene, friction=friction, **settings)
    outcome = execute(program, made, watch=watch)
    assert outcome.fault is None, outcome.fault
    assert outcome.result.incomplete == 0
    (rig,) = rigs
    assert rig.watch is not None
    truths = {truth.cycle: truth for truth in rig.watch.rows}
    return [
        Moment(truths[status.cycle], status, torques)
        for status, torques in told
        if status.cycle in truths
    ]


def pushed(moments: Run, axis: int) -> Array:
    """What the tool exerts on the fixture, along (0 to 2) or about (3 to 5) an axis of its tip."""
    return np.array([-(*m.truth.contact.force, *m.truth.contact.torque)[axis] for m in moments])


def across(moments: Run) -> Array:
    """Size of the contact force across the tip's z, N."""
    return np.array([np.hypot(*m.truth.contact.force[:2]) for m in moments])


def rms(errors: Array) -> float:
    return float(np.sqrt(np.mean(errors**2)))


def touches(moments: Run) -> bool:
    """Whether the tool touched something in every cycle."""
    return all(m.truth.contact.points for m in moments)


def after(moments: Run, seconds: float) -> Run:
    """Without the first seconds."""
    return moments[round(seconds / PERIOD_S) :]


def runs(moments: Run, condition: Callable[[Moment], bool]) -> list[Run]:
    """Stretches of cycles of which a condition holds."""
    found: list[list[Moment]] = [[]]
    for moment in moments:
        if condition(moment):
            found[-1].append(moment)
        elif found[-1]:
            found.append([])
    return [stretch for stretch in found if stretch]
