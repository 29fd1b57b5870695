"""The own joint, as far as a detector asks for one that moves: inertia, friction, brake, sensors.

One axis without gravity: ``inertia`` of the rotor and what hangs on it, Coulomb and viscous
friction, stiction at rest. Its amplifier makes of a code of current_dac the torque that
TORQUE_PER_CODE says, and its encoder, tachometer and current sensor are sound, but for what a
``Fault`` makes of them. It moves from SYNC to SYNC for a period of the cycle, whatever time that
takes: so checks with it hold in real time as well.
"""

from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

from rfms_can.wire.vocabulary import Parameter

SUBSTEPS: Final = 16
"""Steps of integration in a period."""
COULOMB_NM: Final = 0.7
VISCOUS: Final = 0.25
"""Friction, Nm and Nm s/rad: nearly what the bench's joint compensates."""
DETUNED: Final = 1.15
"""Inertia over that for which the bench's gains are made."""
BRAKED_CYCLES: Final = 3
"""SYNCs without a DAC after which the brake is closed."""


class Sample(NamedTuple):
    """What the board tells of one moment.

    Attributes:
        theta: angle by the encoder, rad.
        speed: by the tachometer, rad/s.
        current: code of the current sensor.
        coarse: angle by the potentiometer, rad.
        braked: whether the brake holds.
    """

    theta: float
    speed: float
    current: int
    coarse: float
    braked: bool


class Fault(NamedTuple):
    """What is wrong from some cycle on.

    Attributes:
        name: in words.
        sensed: the sample that the board tells, of the true one, the one at which it began, and
            how many cycles ago that was.
        torque: what the motor makes of the torque that is asked for, Nm.
    """

    name: str
    sensed: Callable[[Sample, Sample, int], Sample] = lambda true, _first, _cycles: true
    torque: Callable[[float], float] = lambda asked: asked


SOUND: Final = Fault("nothing")


class Axis:
    """One joint and its board.

    Args:
        parameters: the bench's.
        theta: where it stands, rad.

    Attributes:
        theta, speed: of the joint itself, rad and rad/s.
        fault: what is wrong.
    """

    def __init__(self, parameters: Mapping[Parameter, float], theta: float) -> None:
        p = parameters
        self._period = p[Parameter.PERIOD]
        self._torque_per_code = p[Parameter.TORQUE_PER_CODE]
        self._inertia = DETUNED * p[Parameter.KP] / p[Parameter.NATURAL_FREQUENCY] ** 2
        self.theta, self.speed = theta, 0.0
        self.fault = SOUND
        self._first: Sample | None = None
        self._cycles = 0
        self._idle = BRAKED_CYCLES

    def begin(self, fault: Fault) -> None:
        """Something is wrong from the next sample on."""
        self.fault = fault

    def period(self, code: int, spoken: bool) -> None:
        """A period under a code of current_dac; ``spoken``: a DAC came in the cycle before."""
        self._idle = 0 if spoken else self._idle + 1
        if self.braked:
            self.speed = 0.0
            return
        step = self._period / SUBSTEPS
        for _ in range(SUBSTEPS):
            self._step(self.fault.torque(code * self._torque_per_code), step)

    @property
    def braked(self) -> bool:
        """Whether the brake holds."""
        return self._idle >= BRAKED_CYCLES

    def _step(self, torque: float, step: float) -> None:
        """Friction stops what it can stop within the step, and never turns it."""
        free = self.speed + step * torque / self._inertia
        most = step * (COULOMB_NM + VISCOUS * abs(self.speed)) / self._inertia
        self.speed = 0.0 if abs(free) <= most else free - (most if free > 0.0 else -most)
        self.theta += step * self.speed

    def sample(self, current: int) -> Sample:
        """What the board tells at SYNC; ``current``: the code that has acted until now."""
        true = Sample(self.theta, self.speed, current, self.theta, self.braked)
        if self.fault is SOUND:
            return true
        if self._first is None:
            self._first = true
        self._cycles += 1
        return self.fault.sensed(true, self._first, self._cycles)
