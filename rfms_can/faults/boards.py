"""Faults of the board of a joint: encoder, tachometer, current sensor, amplifier, motor leads."""

from collections.abc import Callable
from typing import Final

from rfms_can.faults.context import Context
from rfms_can.plant.board import HIGHEST_CODE
from rfms_can.plant.faulty_board import Codes, Damage

GLITCH_PERIODS: Final = 3.0
"""Size of a glitch of the encoder: the way at the speed limit in so many periods."""
JUMP_RAD: Final = 0.1
"""How far an encoder jumps that stays there, rad."""
DRIFT_FRACTION: Final = 0.3
"""Speed with which a slipping encoder drifts, over the joint's speed limit."""
COARSE_FRACTION: Final = 0.25
"""How far a potentiometer is turned on its shaft at most, over the joint's range."""
BETWEEN_INDEXES: Final = (0.4, 0.6)
"""Where it ends between two indexes: by whole intervals it is turned unseen, until it is rigged."""
STUCK_FRACTION: Final = 0.6
"""Current of an amplifier that is stuck, over its limit."""
GAIN: Final = 4
"""Gain of an amplifier that drives too much current, over what it was built for."""

MakeDamage = Callable[[Context], Damage]


def frozen_encoder(_: Context) -> Damage:
    """The encoder counts no more."""
    first: list[int] = []
    return Damage(counts=_kept(first))


def frozen_tachometer(_: Context) -> Damage:
    """The velocity ADC shows the same code for ever."""
    first: list[int] = []
    return Damage(velocity=_kept(first))


def _kept(first: list[int]) -> Callable[[int, int], int]:
    def kept(_: int, value: int) -> int:
        if not first:
            first.append(value)
        return first[0]

    return kept


def glitch(context: Context) -> Damage:
    """One sample of the encoder is far away."""
    off = context.counts(GLITCH_PERIODS * context.speed_limit * context.period_s)
    return Damage(counts=lambda age, counts: counts + off if age == 0 else counts)


def jump(context: Context) -> Damage:
    """The encoder jumps, and goes on from there."""
    off = context.draw.choice((-1, 1)) * context.counts(JUMP_RAD)
    return Damage(counts=lambda _, counts: counts + off)


def drift(context: Context) -> Damage:
    """The encoder slips on its shaft."""
    each = context.draw.choice((-1, 1)) * DRIFT_FRACTION * context.speed_limit * context.period_s
    return Damage(counts=lambda age, counts: counts + context.counts(each * (age + 1)))


def turned_potentiometer(context: Context) -> Damage:
    """The coarse position is elsewhere."""
    lower, upper = context.arm.joint_limits[context.index]
    scale, interval = (
        context.arm.board_scale(context.index),
        context.arm.drives[context.index].index_interval,
    )
    most = int(COARSE_FRACTION * (upper - lower) / interval)
    intervals = context.draw.randint(0, most) + context.draw.uniform(*BETWEEN_INDEXES)
    off = round(intervals * interval / scale.angle_per_coarse_code)
    return Damage(coarse=lambda _, code: min(max(code + off, 0), 4095))


def reversed_encoder(_: Context) -> Damage:
    """The encoder's two channels are exchanged: it counts on, but backwards."""
    first: list[int] = []
    kept = _kept(first)
    return Damage(counts=lambda age, counts: 2 * kept(age, counts) - counts)


def reversed_tachometer(_: Context) -> Damage:
    """The tachometer's leads are exchanged."""
    return Damage(velocity=lambda _, code: -code)


def reversed_motor(_: Context) -> Damage:
    """The motor's leads are exchanged."""
    return Damage(polarity=-1)


def stuck_amplifier(context: Context) -> Damage:
    """The amplifier drives one current, whatever it is told."""
    return _stuck(context.draw.choice((-1, 1)))


def amplifier_drives_up(context: Context) -> Damage:
    """The same, towards the upper end of the joint's range."""
    return _stuck(1 if context.arm.drives[context.index].gear_ratio > 0.0 else -1)


def _stuck(sign: int) -> Damage:
    codes: Codes = (round(sign * STUCK_FRACTION * HIGHEST_CODE), 0)
    return Damage(codes=lambda _, __: codes)


def dead_amplifier(_: Context) -> Damage:
    """The amplifier drives no current."""
    return Damage(codes=lambda _, __: (0, 0))


def strong_amplifier(_: Context) -> Damage:
    """The amplifier drives too much current, up to its limit."""
    return Damage(codes=lambda _, codes: (GAIN * codes[0], GAIN * codes[1]))


def current_rail(_: Context) -> Damage:
    """The current ADC is saturated."""
    return Damage(current=lambda _, __: HIGHEST_CODE)


def velocity_rail(context: Context) -> Damage:
    """The velocity ADC is saturated."""
    rail = context.draw.choice((-1, 1)) * HIGHEST_CODE
    return Damage(velocity=lambda _, __: rail)
