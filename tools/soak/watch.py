"""Reads every cycle of the six joints of a simulated run; no node knows of it.

At the end of each SYNC, before the nodes hear it, what they keep is that of the cycle it ends.
"""

import math
import os
from pathlib import Path
from typing import Any, Final

import numpy as np

from rfms_can.arm import JOINT_COUNT, Arm
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.rig.session import Rig
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import LAST_CYCLE, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Dac, Sync
from rfms_can.wire.vocabulary import NodeState
from soak.margins import COLUMNS, GROUPS, Array, Cycles, Largest, Scales, heat

BLOCK: Final = 2048
"""Cycles that are kept until they are looked at: memory stays as it is, however long a run is."""
OVERLAP: Final = 128
"""Cycles that two blocks share, so that what lasts over their border is seen."""
NO_CODES: Final = (math.nan, math.nan)
LEAST: Final = 1e-9
PAGE_BYTES: Final = os.sysconf("SC_PAGE_SIZE")


def resident_mb() -> float:
    """Resident memory of this process, MB (Linux)."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return round(pages * PAGE_BYTES / 1e6, 1)


class Watch:
    """Watches a run.

    Args:
        arm: the arm's data.
        period_s: of a cycle.

    Attributes:
        cycles: seen, from the first SYNC on.
        enabled: of these, those of an enabled arm.
        largest: of every quantity so far; ``close`` takes in the last cycles.
        passed: whether the number of the cycle went on from 0.
        memory: resident memory of the process, MB: at first, and after each ``BLOCK`` of cycles.
    """

    def __init__(self, arm: Arm, period_s: float) -> None:
        wire = Wire()
        self._scales = Scales.of(arm, period_s)
        self._sync = wire.id(Sync)
        self._dacs = {wire.id(Dac, n): (n - 1, wire.codec(Dac, n)) for n in JOINTS}
        self._codes: list[tuple[float, float]] = [NO_CODES] * JOINT_COUNT
        self._rows = np.zeros((BLOCK + OVERLAP, len(COLUMNS), JOINT_COUNT))
        self._count = self._old = 0
        self._heat = np.zeros(JOINT_COUNT)
        self._rig: SimulatedRig | None = None
        self._number = -1
        self.cycles = self.enabled = 0
        self.passed = False
        self.memory = [resident_mb()]
        self.largest: Largest = {}

    def attach(self, rig: Rig) -> None:
        """Watch this rig from now on."""
        assert isinstance(rig, SimulatedRig)
        if self._rig is not None:
            self.close()
        self._rig, self._number = rig, -1
        rig.observe(self._take)

    def close(self) -> None:
        """Take in the cycles that are left: the run is over."""
        self._look()
        self._count = self._old = 0
        self._heat = np.zeros(JOINT_COUNT)
        self._codes = [NO_CODES] * JOINT_COUNT

    def _take(self, _time_ns: int, frame: Frame) -> None:
        if frame.id == self._sync:
            self._end_cycle()
            return
        known = self._dacs.get(frame.id)
        if known is not None:
            index, codec = known
            dac: Any = codec.unpack(frame.data)
            if dac is not None:
                self._codes[index] = (dac.current_dac, dac.force_dac)

    def _end_cycle(self) -> None:
        rig = self._rig
        assert rig is not None
        number = rig.master.cycle.number
        self.passed |= self._number == LAST_CYCLE and number == 0
        self._number = number
        self.cycles += 1
        self.enabled += rig.joints[0].state is NodeState.OPERATIONAL
        allowed = rig.master.verification.bounds
        values = [
            _of(joint, *codes, bound)
            for joint, codes, bound in zip(rig.joints, self._codes, allowed, strict=True)
        ]
        self._rows[self._count] = np.array(values).T
        self._codes = [NO_CODES] * JOINT_COUNT
        self._count += 1
        if self._count == len(self._rows):
            self._look()
            self._rows[:OVERLAP] = self._rows[-OVERLAP:]
            self._count = self._old = OVERLAP
            self.memory.append(resident_mb())

    def _look(self) -> None:
        """Take the values of the cycles that are kept in."""
        if self._count <= max(self._old, 4):
            return
        cycles = Cycles.of(self._rows[: self._count])
        torque = np.where(cycles.driven, cycles.torque, 0.0)[self._old :]
        most, self._heat = heat(torque, self._scales, self._heat)
        self._note({"heat": most})
        for group in GROUPS:
            self._note(group(cycles, self._scales))

    def _note(self, found: Largest) -> None:
        for name, values in found.items():
            known = self.largest.get(name)
            self.largest[name] = values if known is None else np.maximum(known, values)


_NOTHING: Final = [0.0] * len(COLUMNS)


def _of(joint: JointNode, dac: float, force_dac: float, allowed: float) -> list[float]:
    """``COLUMNS`` of a joint."""
    controller, inputs, rows = joint.controller, joint.inputs, joint.rows
    measure = inputs.measure
    if controller is None or measure is None:
        return _NOTHING
    index = joint.number - 1
    return [
        *(measure.counts, measure.current_adc, measure.velocity_adc, dac, force_dac),
        *(controller.sensing.speed, inputs.errors[index], inputs.rates[index]),
        *(controller.sensing.theta, controller.torque, rows.gravity, rows.own_inertia),
        *(controller.servo.config.design_inertia, allowed),
        *(not rows.selection, controller.drives and not measure.braked, inputs.servoed),
    ]


def settled(values: Array) -> list[float]:
    """Six values as they are kept: three digits, and none of what rounding leaves."""
    return [float(f"{value:.3g}") if value > LEAST else 0.0 for value in values]
