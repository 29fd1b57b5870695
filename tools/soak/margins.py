"""How near a sound arm comes to what a fault would make of it: largest values of what can be seen.

A detector's bound has to lie above the largest value that its quantity takes on arms that have no
fault. Everything here is of what a joint knows by itself: its sample, what it sent, its rows.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.arm import JOINT_COUNT, Arm
from rfms_can.arm.board_scale import FORCE_DAC_FINENESS
from rfms_can.plant.board import HIGHEST_CODE, LOWEST_CODE

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

COLUMNS: Final = (
    *("counts", "current", "tachometer", "dac", "force_dac"),
    *("speed", "error", "rate", "theta", "torque"),
    *("gravity", "inertia", "design", "allowed", "rigid", "driven", "servoed"),
)
"""What is kept of a joint in a cycle; ``Cycles`` says what each is."""
FLAGS: Final = 3
"""Of them, at the end."""
WINDOWS: Final = (3, 5, 10, 25)
"""Cycles that a mismatch of speeds is summed up over."""
LASTING: Final = (1, 2, 3, 4)
"""Cycles that a speed error or a mismatch of currents lasts."""
TOLERATED: Final = 0.05
"""Part of the speed that a mismatch of speeds is allowed."""
SLACK: Final = 0.01
"""Mismatch of speeds over the speed limit that is allowed besides: offsets, rounding."""
VARIATION: Final = (0.1, 3.0)
"""How much the way of a cycle may vary while the tachometer shows one code: that at a part of the
speed limit, and counts."""
STANDS: Final = 0.02
"""Speed over its limit below which a joint at its torque limit does not turn."""
CURRENT_TOLERATED: Final = 0.1
"""Part of the DAC code that a mismatch of currents is allowed: the worst slope is 0.92."""
DELAY: Final = 2
"""Cycles from a DAC code to the current ADC that shows it."""
HEAT_FREE: Final = 0.6
"""Torque over its limit that a motor stands for ever."""
HEAT_S: Final = 5.0
"""Time at the torque limit that is all of the heat, s."""


@dataclass(frozen=True, slots=True, eq=False)
class Cycles:
    """Some cycles in a row; each array is (n, 6), of a cycle's end.

    Attributes:
        counts: of the encoder.
        current, tachometer: codes of the two ADCs.
        dac, force_dac: codes sent; NaN in a cycle without.
        speed: by the tachometer, rad/s.
        error, rate: commanded less measured, rad and rad/s.
        theta: measured, rad.
        torque: commanded, Nm.
        gravity, inertia: of the rows, Nm and kg m2.
        design: inertia that the gains were made for, kg m2.
        allowed: following error that the master allows a rigid joint, rad.
        rigid: whether nothing complies.
        driven: whether DAC codes go out and the brake is open.
        servoed: whether the servo's torque of the cycle has been made.
    """

    counts: Array
    current: Array
    tachometer: Array
    dac: Array
    force_dac: Array
    speed: Array
    error: Array
    rate: Array
    theta: Array
    torque: Array
    gravity: Array
    inertia: Array
    design: Array
    allowed: Array
    rigid: Mask
    driven: Mask
    servoed: Mask

    @classmethod
    def of(cls, rows: Array) -> "Cycles":
        """Of rows of ``COLUMNS`` (n, columns, 6)."""
        columns: Any = [rows[:, column, :] for column in range(len(COLUMNS))]
        flags = len(COLUMNS) - FLAGS
        return cls(*columns[:flags], *(column > 0.5 for column in columns[flags:]))

    def __len__(self) -> int:
        return len(self.counts)


class Scales(NamedTuple):
    """Of the six joints of an arm, (6,) each.

    Attributes:
        speed: limit, rad/s.
        torque: limit, Nm.
        step: angle of an encoder count, rad, signed.
        lower, upper: ends of the range, rad.
        period_s: of a cycle.
    """

    speed: Array
    torque: Array
    step: Array
    lower: Array
    upper: Array
    period_s: float

    @classmethod
    def of(cls, arm: Arm, period_s: float) -> "Scales":
        """The arm's."""
        drives = arm.drives
        lower, upper = zip(*arm.joint_limits, strict=True)
        return cls(
            np.array(arm.speed_limits),
            np.array([drive.torque_limit for drive in drives]),
            1.0 / np.array([drive.counts_per_radian for drive in drives]),
            np.array(lower),
            np.array(upper),
            period_s,
        )


Largest = dict[str, Array]
"""Largest value of each quantity, by name: (6,)."""


def largest(values: Array, where: Mask | None = None) -> Array:
    """Of each joint, of cycles where it is known; 0 where it is nowhere."""
    known = ~np.isnan(values) if where is None else where & ~np.isnan(values)
    return np.asarray(np.where(known, values, 0.0).max(axis=0, initial=0.0))


def longest(condition: Mask) -> Array:
    """Cycles in a row for which a condition (n, 6) holds, (6,)."""
    run, found = np.zeros(JOINT_COUNT), np.zeros(JOINT_COUNT)
    for holds in condition:
        run = (run + 1.0) * holds
        np.maximum(found, run, out=found)
    return found


def sums(values: Array, window: int) -> Array:
    """Sums over so many cycles in a row, (n - window + 1, 6)."""
    if len(values) < window:
        return np.zeros((0, JOINT_COUNT))
    total = np.vstack([np.zeros(JOINT_COUNT), np.cumsum(values, axis=0)])
    return np.asarray(total[window:] - total[:-window])


def lasting(values: Array, cycles: int) -> Array:
    """Largest size that a value keeps, or exceeds, for some cycles in a row, of one sign; (6,)."""
    if len(values) < cycles:
        return np.zeros(JOINT_COUNT)
    known = np.nan_to_num(values)
    rows = [known[shift : len(known) - cycles + 1 + shift] for shift in range(cycles)]
    above, below = np.min(rows, axis=0), np.max(rows, axis=0)
    return np.asarray(np.maximum(above, -below).max(axis=0, initial=0.0))


# --- the quantities ------------------------------------------------------------------------------


def speeds(cycles: Cycles, scales: Scales) -> Largest:
    """Tachometer against encoder; what stands still while the other goes on."""
    driven = cycles.driven[1:] & cycles.driven[:-1]
    steps = np.diff(cycles.counts, axis=0)
    rate = steps * scales.step / scales.period_s
    count = np.abs(scales.step) / scales.period_s
    mean = 0.5 * (cycles.speed[1:] + cycles.speed[:-1])
    found = {"speed": largest(np.abs(cycles.speed) / scales.speed, cycles.driven)}
    off = over = mean
    for name, told in (("tachometer", cycles.speed[1:]), ("mean tachometer", mean)):
        off = np.where(driven, told - rate, 0.0) / scales.speed
        found[f"{name} off"] = largest(np.abs(off))
        allowed = (TOLERATED * np.maximum(np.abs(told), np.abs(rate)) + count) / scales.speed
        over = np.maximum(np.abs(off) - allowed, 0.0)
        found[f"{name} over"] = largest(over)
    for window in WINDOWS:  # of the mean alone: an encoder's rate is one
        found[f"mean tachometer over, {window}"] = largest(sums(over, window))
        found[f"mean tachometer sum, {window}"] = largest(np.abs(sums(off, window)))
    same = driven & (np.diff(cycles.tachometer, axis=0) == 0.0)
    still = driven & (steps == 0.0)
    for part in (0.02, 0.05):
        fast = part * scales.speed
        found[f"tachometer stands, {part}"] = longest(same & (np.abs(rate) > fast))
        found[f"encoder stands, {part}"] = longest(still & (np.abs(mean) > fast))
    found["sensors apart"] = apart(cycles, rate, mean, driven, scales)
    bound = VARIATION[0] * scales.speed * scales.period_s + VARIATION[1] * np.abs(scales.step)
    moved = np.where(driven, steps * scales.step, 0.0)
    found["varies at one code"] = variation(cycles.tachometer[1:], moved, driven) / bound
    return found


def apart(cycles: Cycles, rate: Array, mean: Array, driven: Mask, scales: Scales) -> Array:
    """Largest one-sided cumulative sum (Page 1954) of the difference of both rates, less the slack,
    over the speed limit, cycles (6,)."""
    most = np.maximum(np.abs(cycles.speed[1:]), np.abs(cycles.speed[:-1]))
    slack = SLACK + TOLERATED * most / scales.speed
    off = (rate - mean) / scales.speed
    zero = np.zeros(JOINT_COUNT)
    sides = (np.where(driven, side * off - slack, -np.inf) for side in (1.0, -1.0))
    up, down = (reflected(np.maximum(side, -1e3), zero).max(axis=0) for side in sides)
    return np.asarray(np.maximum(up, down))


def reflected(steps: Array, before: Array) -> Array:
    """Sums of steps (n, 6) that never fall below 0, from ``before`` (6,) on."""
    total = before + np.cumsum(steps, axis=0)
    return np.asarray(total - np.minimum(np.minimum.accumulate(total, axis=0), 0.0))


def variation(codes: Array, moved: Array, driven: Mask) -> Array:
    """How far the ways of cycles with one code in a row lie apart, the largest (6,)."""
    found = np.zeros(JOINT_COUNT)
    for joint in range(JOINT_COUNT):
        code, way = np.where(driven[:, joint], codes[:, joint], np.nan), moved[:, joint]
        begins = np.flatnonzero(np.r_[True, ~(code[1:] == code[:-1])])
        most = np.maximum.reduceat(way, begins) - np.minimum.reduceat(way, begins)
        found[joint] = most.max()
    return found


def currents(cycles: Cycles, _scales: Scales) -> Largest:
    """Current ADC against the DAC codes that it shows, in codes."""
    asked = cycles.dac[:-DELAY] + cycles.force_dac[:-DELAY] / FORCE_DAC_FINENESS
    asked = np.clip(asked, LOWEST_CODE, HIGHEST_CODE)
    known = cycles.driven[DELAY:] & cycles.driven[:-DELAY] & cycles.driven[1:-1]
    off = np.where(known, cycles.current[DELAY:] - asked, 0.0)
    over = np.sign(off) * np.maximum(np.abs(off) - CURRENT_TOLERATED * np.abs(asked), 0.0)
    return {
        f"{name}, {lasts}": lasting(values, lasts)
        for name, values in (("current off", off), ("current over", over))
        for lasts in LASTING
    }


def following(cycles: Cycles, scales: Scales) -> Largest:
    """Errors of position and speed; torque; distance beyond the range."""
    rigid = cycles.servoed & cycles.rigid
    rate = np.where(rigid, cycles.rate / scales.speed, 0.0)
    torque = np.where(cycles.driven, cycles.torque / scales.torque, 0.0)
    inside = np.minimum(cycles.theta - scales.lower, scales.upper - cycles.theta)
    found = {f"speed error, {lasts}": lasting(rate, lasts) for lasts in LASTING}
    found["error, rad"] = largest(np.abs(cycles.error), rigid)
    allowed = np.where(cycles.allowed > 0.0, cycles.allowed, np.inf)
    found["error over the master's"] = largest(np.abs(cycles.error) / allowed, rigid)
    found["error complying, rad"] = largest(np.abs(cycles.error), cycles.servoed & ~cycles.rigid)
    found["torque"] = lasting(torque, 1)
    limited = np.abs(torque) > 1.0 - 1e-6
    found["torque at its limit"] = longest(limited)
    found["stalls"] = longest(limited & (np.abs(cycles.speed) < STANDS * scales.speed))
    found["beyond range, rad"] = largest(-inside, cycles.servoed)
    return found


def rows(cycles: Cycles, scales: Scales) -> Largest:
    """Change of gravity and own inertia from one set of rows to the next."""
    gravity = np.abs(np.diff(cycles.gravity, axis=0)) / scales.torque
    before, after = cycles.inertia[:-1], cycles.inertia[1:]
    least = np.minimum(np.abs(before), np.abs(after))
    change = np.abs(after - before) / np.where(least > 0.0, least, np.inf)
    known = cycles.servoed[1:] & cycles.servoed[:-1]
    design = np.where(cycles.design > 0.0, cycles.design, np.inf)
    return {
        "gravity step": largest(gravity, known),
        "inertia step": largest(change, known),
        "inertia over design": largest(np.abs(cycles.inertia) / design, cycles.servoed),
        "gravity": largest(np.abs(cycles.gravity) / scales.torque, cycles.servoed),
    }


GROUPS: Final[tuple[Callable[[Cycles, Scales], Largest], ...]] = (
    speeds,
    currents,
    following,
    rows,
)
"""All quantities but heat, which needs every cycle."""


def heat(torque: Array, scales: Scales, before: Array) -> tuple[Array, Array]:
    """Heat of a motor over time: torque^2 above what it stands for ever, integrated; never below 0.

    Args:
        torque: commanded, Nm (n, 6); 0 where the joint is not driven.
        scales: of the arm.
        before: heat before the first of them, as a part of that of ``HEAT_S`` at the limit (6,).

    Returns:
        The largest heat, and the last, (6,) each.
    """
    whole = (1.0 - HEAT_FREE**2) * HEAT_S
    gain = ((torque / scales.torque) ** 2 - HEAT_FREE**2) * scales.period_s / whole
    level = reflected(gain, before)
    return np.asarray(level.max(axis=0)), level[-1]
