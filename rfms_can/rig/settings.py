"""Settings of a run; every field is a flag of ``rfms run`` and a key of the config file."""

import secrets
from dataclasses import asdict, dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any, Final, TypeVar

from rfms_can.arm import Arm, arm_by_name, friction_set
from rfms_can.arm.calibration import load_calibration
from rfms_can.bus.timing import BusTiming
from rfms_can.bus.url import HUB, SIM, parse_bus_url
from rfms_can.compliance import LAWS, ControlLaw
from rfms_can.dynamics.model import FULL, NONE, check_kind
from rfms_can.errors import RfmsError
from rfms_can.master.settings import CLOCKS, MasterSettings
from rfms_can.master.traffic import BusTime
from rfms_can.plant.physics import physics_steps
from rfms_can.plant.scene import Scene
from rfms_can.plant.scene.catalogue import scene_from
from rfms_can.plant.variant import make_variant
from rfms_can.plant.wrist_sensor import NO_SENSOR, sensor_from
from rfms_can.wire.configuration import Clock
from rfms_can.wire.vocabulary import Blend

Kind = TypeVar("Kind", bound=IntEnum)

LARGEST_ERROR_RAD: Final = 2.0
"""Bound of ``following_error``: ERROR tells no more."""
LISTENING_S: Final = 0.1
"""Time that a master listens for another one before it sends anything, at least, s: HEARTBEAT comes
twice in it at 250 Hz."""
LISTENING_CYCLES: Final = 3
"""The same in cycles, at low rates."""
LONGEST_S: Final = 3600.0
"""Longest barrier and patience, s."""
OPEN: Final = "open"
CLOSED: Final = "closed"
FORCE_LOOPS: Final = (OPEN, CLOSED)
"""Whether the force loop is closed over the wrist sensor."""


class SettingsError(RfmsError, ValueError):
    """An unknown setting or value, or two that exclude one another."""


@dataclass(frozen=True, slots=True)
class RunSettings:
    """Settings of one run.

    Attributes:
        arm: name of the arm.
        bus: bus URL (``bus/url.py``).
        clock: ``virtual``, ``lockstep`` or ``realtime``; by the bus if empty.
        rate: control rate, Hz.
        friction: friction set of the plant.
        plant: true parameters of the plant (``plant/variant.py``).
        servo_friction: friction set the servos compensate; the plant's if empty.
        dynamics: model of the master's compensation: ``full``, ``simplified`` or ``none``.
        calibration: file of ``rfms identify``; the arm's published numbers if empty.
        blend: of transitions: ``continuous`` matches position, velocity, acceleration and jerk,
            ``thesis`` position and velocity only, as (3.17) to (3.19).
        bit_rate, data_bit_rate: of the simulated bus and the hub, bit/s.
        barrier: longest lockstep cycle, s.
        patience: how long nodes may take to appear, s.
        seed: of the boot ids and the sensor's noise; without one, boot ids are random where nodes
            are processes, so that one that starts again is noticed.
        scene: tool and fixtures: ``NAME`` or ``NAME:key=value,...``
            (``plant/scene/catalogue.py``).
        sensor: at its wrist: ``none``, ``ideal`` or ``good``.
        law: how the arm complies: a word of ``compliance.ControlLaw``.
        force_loop: ``open``, ``closed`` over the sensor, or empty: closed if there is one.
        dither: fraction of the friction that complying joints dither with at rest, 0 to 1.
        following_error: largest error of a joint against what was commanded, rad; 0: by its
            stiffness (``master/verification.py``).
    """

    arm: str = "puma260"
    bus: str = SIM
    clock: str = ""
    rate: float = 250.0
    friction: str = "corke"
    plant: str = "nominal"
    servo_friction: str = ""
    dynamics: str = FULL
    calibration: str = ""
    blend: str = "continuous"
    bit_rate: int = 1_000_000
    data_bit_rate: int = 5_000_000
    barrier: float = 2.0
    patience: float = 30.0
    seed: int | None = None
    scene: str = "free"
    sensor: str = NO_SENSOR
    law: str = ControlLaw.WEIGHTED.value
    force_loop: str = ""
    dither: float = 0.0
    following_error: float = 0.0

    def __post_init__(self) -> None:
        arm = arm_by_name(self.arm)
        friction_set(arm, self.friction)
        friction_set(arm, self.servo_friction or self.friction)
        physics_steps(self.rate, self.the_scene.longest_step_s)
        sensor_from(self.sensor, self.noise_seed)
        make_variant(self.plant, arm, self.friction)
        self._check_force()
        simulated = parse_bus_url(self.bus).interface == SIM
        check_kind(self.dynamics)
        if self.calibration:
            load_calibration(Path(self.calibration)).check(arm)
        choice("blend", self.blend, Blend)
        one_process = CLOCKS[self.the_clock].in_one_process
        if simulated and not one_process:
            raise SettingsError(
                f"clock {self.clock!r} needs processes on a hub or a CAN interface; bus 'sim' "
                f"runs in virtual time"
            )
        if one_process and not simulated:
            raise SettingsError(
                f"clock {self.clock!r} works only on bus 'sim'; {self.bus} needs 'lockstep'"
            )
        for name in ("barrier", "patience"):
            if not 0.0 < getattr(self, name) <= LONGEST_S:
                raise SettingsError(
                    f"{name} {getattr(self, name):g} s is not in 0..{LONGEST_S:g} s, 0 excluded"
                )
        if not 0.0 <= self.following_error <= LARGEST_ERROR_RAD:
            raise SettingsError(
                f"following error {self.following_error:g} rad is not in 0..{LARGEST_ERROR_RAD:g} "
                f"rad; 0 is the bound by each joint's stiffness"
            )
        BusTiming(self.bit_rate, self.data_bit_rate)

    def _check_force(self) -> None:
        words = [law.value for law in LAWS]
        if self.law not in words:
            raise SettingsError(f"law {self.law!r} does not exist; there are: {', '.join(words)}")
        if self.dynamics == NONE and LAWS[ControlLaw(self.law)].needs_model:
            raise SettingsError(
                f"law {self.law!r} needs a model of the arm: with dynamics 'none' take law 'hybrid'"
            )
        if self.force_loop and self.force_loop not in FORCE_LOOPS:
            raise SettingsError(f"force loop {self.force_loop!r}: it is {' or '.join(FORCE_LOOPS)}")
        if self.force_loop == CLOSED and self.sensor == NO_SENSOR:
            raise SettingsError("force loop 'closed' needs a wrist sensor: add --sensor good")
        if not 0.0 <= self.dither <= 1.0:
            raise SettingsError(f"dither must be a fraction from 0 to 1, got {self.dither:g}")

    @property
    def simulated(self) -> bool:
        """Whether all nodes run in this process, in virtual time."""
        return parse_bus_url(self.bus).interface == SIM

    @property
    def the_arm(self) -> Arm:
        """The arm's data."""
        return arm_by_name(self.arm)

    @property
    def the_scene(self) -> Scene:
        """Tool and fixtures."""
        return scene_from(self.scene, self.arm)

    @property
    def the_clock(self) -> Clock:
        """The clock that starts the cycles."""
        return choice("clock", self.clock or ("virtual" if self.simulated else "lockstep"), Clock)

    @property
    def watch_ns(self) -> int:
        """Time between two SYNCs, ns: the control period, or the barrier in lockstep."""
        return self.master().cycle_limit_ns

    @property
    def noise_seed(self) -> int:
        """Seed of the sensor's noise."""
        return 1 if self.seed is None else self.seed

    def boot_id(self, node: int) -> int:
        """Boot id of a node that starts now: by the seed, or another one at every start.

        In one process (bus ``sim``) no node can start again, and runs repeat to the bit.
        """
        if self.seed is None and not self.simulated:
            return secrets.randbits(32)
        return (self.noise_seed << 8 | node) & 0xFFFFFFFF

    def master(self, *, paced: bool = False) -> MasterSettings:
        """The master's settings; ``paced`` for a bus without a program."""
        return MasterSettings(
            rate_hz=self.rate,
            clock=self.the_clock,
            friction=self.servo_friction or self.friction,
            dynamics=self.dynamics,
            calibration=load_calibration(Path(self.calibration)) if self.calibration else None,
            blend=choice("blend", self.blend, Blend),
            barrier_s=self.barrier,
            patience_s=self.patience,
            paced=paced,
            law=ControlLaw(self.law),
            sensor=self.sensor != NO_SENSOR,
            closed=self.sensor != NO_SENSOR and self.force_loop != OPEN,
            dither=self.dither,
            following_error=self.following_error,
            bus_time=self._bus_time,
            listening_s=0.0 if self.simulated else max(LISTENING_S, LISTENING_CYCLES / self.rate),
        )

    @property
    def _bus_time(self) -> BusTime | None:
        """How long a frame takes on the bus; None on an interface that has its own bit rates."""
        if parse_bus_url(self.bus).interface not in (SIM, HUB):
            return None
        return BusTiming(self.bit_rate, self.data_bit_rate).exact_ns

    def as_dict(self) -> dict[str, Any]:
        """For JSON and TOML."""
        return asdict(self)


def choice(what: str, word: str, kind: type[Kind]) -> Kind:
    """The member of an enumeration that a lower-case word names."""
    words = {member.name.lower(): member for member in kind}
    if word not in words:
        raise SettingsError(f"{what} {word!r} does not exist; there are: {', '.join(words)}")
    return words[word]
