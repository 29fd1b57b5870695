"""Conditions common to all runs of a campaign: printed with its table, first line of its file."""

import hashlib
from pathlib import Path
from typing import Any

import msgspec

from rfms_can.analysis.campaign.job import FRICTIONS, TASKS, Job, groups_of
from rfms_can.errors import RfmsError
from rfms_can.master.force.bias import (
    CONTACT,
    DEAD_BAND,
    INTEGRAL_FADE_S,
    INTEGRAL_RATE,
    PROPORTIONAL,
)
from rfms_can.master.rows.math_processor import COMPLIANT_DAMPING
from rfms_can.messages import Vector6
from rfms_can.plant.scene.peg_in_hole import PegInHole
from rfms_can.rig.gains import gains


class Conditions(msgspec.Struct, frozen=True, kw_only=True):
    """Settings of the arm, its servos, the contact and the peg.

    Attributes:
        arm, rate_hz, sensor, dither: as flags of ``rfms run``.
        natural_frequency, damping_ratio: of every joint's error under every law, rad/s.
        kp, ki, kd: the same as gains, joint by joint: Nm/rad, Nm/(rad s), Nms/rad. The weighted
            law takes the two numbers above on the arm's inertia at each pose instead of kp and kd.
        compliant_damping: of the directions that comply, 1/s.
        proportional, integral_rate: of the force loop where it is closed, 1 and 1/s.
        dead_band, touch: error treated as zero, and contact threshold, N and N m.
        forget_s: decay time constant of its integral without contact, s.
        stiffness: of the contact, N/m.
        sliding: its coefficient of friction.
        radius, clearance, chamfer: of the peg and the hole, m.
        program: file name of the program.
        digest: of its text: first digits of its SHA-256.
    """

    arm: str
    rate_hz: float
    sensor: str
    dither: float
    natural_frequency: float
    damping_ratio: float
    kp: tuple[float, ...]
    ki: tuple[float, ...]
    kd: tuple[float, ...]
    compliant_damping: float
    proportional: float
    integral_rate: float
    dead_band: Vector6
    touch: Vector6
    forget_s: float
    stiffness: float
    sliding: float
    radius: float
    clearance: float
    chamfer: float
    program: str
    digest: str

    @classmethod
    def of(cls, program: Path, dither: float) -> "Conditions":
        """Those of a campaign with a program.

        Raises:
            RfmsError: the program cannot be read.
        """
        try:
            text = program.read_bytes()
        except OSError as error:
            raise RfmsError(f"program {program} cannot be read: {error.strerror}") from error
        group = groups_of(TASKS, FRICTIONS)[0]
        settings = Job(group, 0, dither).settings
        servos, contact, peg = gains(settings), settings.the_scene.contact, PegInHole()
        return cls(
            arm=settings.arm,
            rate_hz=settings.rate,
            sensor=settings.sensor,
            dither=dither,
            natural_frequency=servos[0].natural_frequency,
            damping_ratio=servos[0].damping_ratio,
            kp=tuple(round(servo.kp, 2) for servo in servos),
            ki=tuple(round(servo.ki, 1) for servo in servos),
            kd=tuple(round(servo.kd, 3) for servo in servos),
            compliant_damping=COMPLIANT_DAMPING,
            proportional=PROPORTIONAL,
            integral_rate=INTEGRAL_RATE,
            dead_band=DEAD_BAND,
            touch=CONTACT,
            forget_s=INTEGRAL_FADE_S,
            stiffness=contact.stiffness,
            sliding=contact.friction,
            radius=peg.radius,
            clearance=peg.clearance,
            chamfer=peg.chamfer,
            program=program.name,
            digest=hashlib.sha256(text).hexdigest()[:12],
        )

    @property
    def lines(self) -> list[str]:
        """As text."""

        def joints(values: tuple[float, ...], digits: int) -> str:
            return ", ".join(f"{value:.{digits}f}" for value in values)

        return [
            f"{self.arm} at {self.rate_hz:g} Hz, servos compensate the friction the plant has, "
            f"dither {self.dither:g} of it, wrist sensor {self.sensor}; program {self.program}",
            f"peg of {2e3 * self.radius:g} mm, radial clearance {1e3 * self.clearance:g} mm, "
            f"chamfer {1e3 * self.chamfer:g} mm; contact {self.stiffness:.0e} N/m, "
            f"friction {self.sliding:g}",
            f"gains of all laws: natural frequency {self.natural_frequency:g} rad/s, damping ratio "
            f"{self.damping_ratio:g}",
            f"K_p {joints(self.kp, 1)} Nm/rad",
            f"K_i {joints(self.ki, 0)} Nm/(rad s)",
            f"K_d {joints(self.kd, 2)} Nms/rad",
            f"compliant directions are damped by {self.compliant_damping:g}/s",
            f"a closed loop asks for f + {self.proportional:g} e + {self.integral_rate:g}/s ∫e dt; "
            f"where f is 0, an e within {self.dead_band[0]:g} N and {self.dead_band[3]:g} N m is "
            f"ignored; without contact, below {self.touch[0]:g} N and {self.touch[3]:g} N m, the "
            f"integral decays within {self.forget_s:g} s",
        ]


def as_plain(conditions: Conditions) -> dict[str, Any]:
    """For JSON."""
    return msgspec.structs.asdict(conditions)
