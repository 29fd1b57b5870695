"""The result of a run: the table at its end, and ``summary.json``."""

from typing import Any

import msgspec

from rfms_can.arm import Arm
from rfms_can.master.node import MasterNode
from rfms_can.master.statistics import RunStatistics, Tracking
from rfms_can.messages.culprit import Culprit
from rfms_can.rig.truth import SceneResult
from rfms_can.wire.nodes import JOINTS


class JointResult(msgspec.Struct, frozen=True):
    """One joint's tracking: largest and rms error while moving, largest once settled, rad.

    The latter is None where the run never rested long enough to settle.
    """

    joint: int
    moving_max: float
    moving_rms: float
    settled_max: float | None
    settled_max_counts: float | None


class RunResult(msgspec.Struct, frozen=True):
    """Numbers of a run.

    Attributes:
        fault: why it was halted, or None.
        culprit: who is to blame for that, and by what; None where it was not halted.
        error: why the program ended early otherwise, or None.
        cycles: control cycles while enabled.
        incomplete: cycles that ended before all had answered (deadline misses).
        missing: frames missing in them.
        joints: tracking.
        frames: frames on the bus, all phases.
        bus_load: measured, fraction of the bus time; None where it cannot be measured.
        bus_bound: worst-case load of a cycle of such a run, fraction of the bus time.
        discarded: frames refused, by node.
        foreign: frames on the bus that are not in the contract.
        lost: frames missed by the master, by gaps of their counters.
        lateness: histogram of late SYNCs (real time only).
        wall_s: wall-clock time of the enabled part, s.
        scene: contact with the scene; None without a scene, or if the plant is in another process.
        reset_faults: faults that a reset has ended, oldest first.
        bus_offs: how often a node's controller went bus-off, by node, where it did.
        overflows: frames that a node's port lost because a queue was full (ENOBUFS on sending,
            or the receive queue), by node, where there were any; 255 from a heartbeat is the most.
        unrecorded: what of the record is missing, and why: a log that is cut, files not written.
        reported: singularities met while the arm complied, in words, each once.
    """

    fault: str | None
    error: str | None
    cycles: int
    incomplete: int
    missing: dict[str, int]
    joints: list[JointResult]
    frames: int
    bus_load: float | None
    bus_bound: float | None
    discarded: dict[str, int]
    foreign: int
    lost: int
    lateness: list[int]
    wall_s: float
    scene: SceneResult | None = None
    reported: list[str] = []
    reset_faults: list[str] = []
    unrecorded: list[str] = []
    bus_offs: dict[str, int] = {}
    overflows: dict[str, int] = {}
    culprit: Culprit | None = None

    @property
    def cycles_per_s(self) -> float:
        """Control cycles per second of wall-clock time."""
        return self.cycles / self.wall_s if self.wall_s else 0.0

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        values: dict[str, Any] = msgspec.to_builtins(self)
        return {**values, "cycles_per_s": self.cycles_per_s}


def joint_results(arm: Arm, statistics: RunStatistics) -> list[JointResult]:
    """Tracking of the six joints."""

    def joint_result(joint: int, moving: Tracking, settled: Tracking) -> JointResult:
        counts_per_rad = abs(arm.drives[joint - 1].counts_per_radian)
        return JointResult(
            joint,
            moving.largest,
            moving.rms,
            settled.largest if settled.count else None,
            settled.largest * counts_per_rad if settled.count else None,
        )

    return [
        joint_result(joint, moving, settled)
        for joint, moving, settled in zip(
            JOINTS, statistics.moving, statistics.settled, strict=True
        )
    ]


def discarded_frames(master: MasterNode) -> dict[str, int]:
    """Frames each node has discarded, as its last heartbeat says; the master's own count too."""
    counts = master.bring_up.roster.discarded()
    return {**counts, master.name: master.discarded}


def troubled_ports(master: MasterNode) -> tuple[dict[str, int], dict[str, int]]:
    """Bus-offs and overflows by node, where there were any: heartbeats, and the master's port."""
    ports = {**master.bring_up.roster.ports(), master.name: master.port_counts()}
    bus_offs = {name: counts.bus_offs for name, counts in ports.items() if counts.bus_offs}
    overflows = {name: counts.overflows for name, counts in ports.items() if counts.overflows}
    return bus_offs, overflows
