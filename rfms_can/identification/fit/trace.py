"""An experiment's frames in SI units: angles by the encoders, currents by the ADCs.

Of the arm's data only the sensors' data sheet is used: counts per radian, the direction of each
gear, the scale of the tachometer. A current is in DAC codes, positive if it drives its joint to
positive angles.
"""

from typing import NamedTuple

import numpy as np

from rfms_can.analysis.cycles import Floats
from rfms_can.arm import JOINT_COUNT, Arm
from rfms_can.identification.experiments.actions import Mark
from rfms_can.identification.experiments.data import Data
from rfms_can.identification.experiments.tap import MISSING
from rfms_can.identification.fit.least_squares import Fit, IdentificationError, solve

ANSWER_CYCLES = 2
"""A DAC code of cycle k is latched at SYNC k + 1 and is the ADC's current of MEASURE k + 2."""


class Trace(NamedTuple):
    """One experiment.

    Attributes:
        q: joint angles at each SYNC, rad (n, 6).
        qd: speeds by the tachometer, rad/s (n, 6).
        current: of the period that ends at each SYNC, DAC codes (n, 6).
        marks: of its motions, in rows.
        period_s: between two rows, s.
        load: whether the known load was in the hand.
    """

    q: Floats
    qd: Floats
    current: Floats
    marks: tuple[Mark, ...]
    period_s: float
    load: bool


def converter_fits(arm: Arm, tables: list[Data]) -> list[Fit]:
    """Eq. 4.14 of each joint: ``slope`` A_c and ``offset`` B_c of I_adc = A_c I_dac + B_c."""
    fits = []
    for joint in range(JOINT_COUNT):
        dac = np.concatenate([data.table[:-ANSWER_CYCLES, 3, joint] for data in tables])
        adc = np.concatenate([data.table[ANSWER_CYCLES:, 1, joint] for data in tables])
        whole = (dac != MISSING) & (adc != MISSING)
        codes = dac[whole].astype(np.float64)
        matrix = np.column_stack((codes, np.ones_like(codes)))
        what = f"{arm.name}, joint {joint + 1}, DAC and ADC"
        fits.append(solve(("slope", "offset"), matrix, adc[whole].astype(np.float64), what))
    return fits


def trace_of(arm: Arm, data: Data, converters: list[Fit]) -> Trace:
    """The data in SI units.

    Raises:
        IdentificationError: frames are missing.
    """
    if (data.table == MISSING).any():
        missing = int((data.table == MISSING).any(axis=(1, 2)).sum())
        raise IdentificationError(f"{missing} cycles lack a MEASURE or DAC frame: run them again")
    counts_per_rad = np.array([drive.counts_per_radian for drive in arm.drives])
    gears = np.sign([drive.gear_ratio for drive in arm.drives])
    speeds = np.array([arm.board_scale(joint).speed_per_adc_code for joint in range(JOINT_COUNT)])
    slope = np.array([fit.values["slope"] for fit in converters])
    offset = np.array([fit.values["offset"] for fit in converters])
    counts, adc, tachometer, _ = (data.table[:, field, :].astype(np.float64) for field in range(4))
    return Trace(
        (counts - np.array(data.zero_counts)) / counts_per_rad,
        tachometer * speeds,
        gears * (adc - offset) / slope,
        data.marks,
        data.period_s,
        data.load,
    )
