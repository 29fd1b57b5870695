"""Wiring check before any servo is closed: small torques on one joint at a time.

A node in place of the master, on a bus whose joint nodes are silent. It sends SYNC and the DAC
codes of one joint; all others stay braked. A current pulse in either direction, as weak as moves
the joint; between pulses the brake is on, and a RESET before the next lets the board open it: a
joint that fell silent counts as lost. The gravity torque is the same in both and cancels.

Encoder, tachometer and coarse position each give the direction of the motion. One that contradicts
the others is reversed; if all contradict the current, the motor is reversed.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Final, NamedTuple

from rfms_can.arm import Arm
from rfms_can.node.endpoint import Endpoint
from rfms_can.node.protocol import NOTHING
from rfms_can.wire.contract import NO_SET, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import HEARTBEAT_EVERY, JOINTS, MASTER
from rfms_can.wire.records import Dac, Measure, Nmt, Reference, Sync
from rfms_can.wire.vocabulary import Command, NodeState

FULL_SCALE: Final = 2048
LEVELS: Final = tuple(round(FULL_SCALE * percent / 100.0) for percent in range(4, 50, 3))
"""DAC codes of the pulses, weakest first; the last is the largest the probe ever applies."""
PULSE_CYCLES: Final = 15
REST_CYCLES: Final = 6
"""Between pulses: the plant brakes a joint that has been silent for three cycles."""
DETECTABLE: Final = 0.006
"""Difference of the displacements of two opposite pulses, rad, that identifies the directions."""
MAX_DISPLACEMENT: Final = 0.02
"""Displacement, rad, after which a pulse is ended immediately."""
AGREEMENT: Final = 0.3
"""Fraction of the largest displacement below which a sensor has not measured the motion."""


class Finding(NamedTuple):
    """Result of the probe for one joint.

    Attributes:
        joint: 1 to 6.
        code: of the pulses that moved it, or the largest applied.
        encoder, tachometer, coarse: displacement in the direction of the current less that in the
            other direction, rad, by each sensor, with the signs and scales of the data sheet.
    """

    joint: int
    code: int
    encoder: float
    tachometer: float
    coarse: float

    @property
    def problem(self) -> str | None:
        """The fault in words, or None."""
        displacements = {
            "encoder": self.encoder,
            "tachometer": self.tachometer,
            "coarse position": self.coarse,
        }
        largest = max(map(abs, displacements.values()))
        percent = 100.0 * self.code / FULL_SCALE
        if largest < DETECTABLE:
            return (
                f"joint {self.joint} does not move at {percent:.0f} % of its current: check its "
                f"brake, its load and its motor's wires"
            )
        unseen = [name for name, d in displacements.items() if abs(d) < AGREEMENT * largest]
        if unseen:
            return f"joint {self.joint}: {' and '.join(unseen)} does not follow the motion"
        backwards = [name for name, d in displacements.items() if d < 0.0]
        if len(backwards) == len(displacements):
            return f"joint {self.joint}: its motor turns backwards: exchange its wires"
        if backwards:
            names = " and ".join(backwards)
            verb = "counts" if backwards == ["encoder"] else "reads"
            return f"joint {self.joint}: its {names} {verb} backwards: exchange its wires"
        return None


class Probe(Endpoint):
    """Node 8 during the probe.

    Args:
        arm: the arm on the bus: scales of its boards by the data sheet.
        wire, boot_id: see ``Endpoint``.
        period_ns: control period, ns.

    Attributes:
        findings: of the joints probed so far.
        done: whether all joints have been probed.
        largest_code: the largest code sent.
        largest_displacement: of any joint in a pulse, rad, by its coarse position or encoder.
    """

    def __init__(self, arm: Arm, wire: Wire, boot_id: int, period_ns: int) -> None:
        super().__init__(MASTER, wire, boot_id)
        self.findings: list[Finding] = []
        self.done = False
        self.largest_code = 0
        self.largest_displacement = 0.0
        self._arm = arm
        self._period_ns = period_ns
        self._deadline_ns: int | None = 0
        self._cycle = -1
        self._sync = self._sends(Sync)
        self._nmt = self._sends(Nmt)
        self._pulsed = -1  # joint that a code was sent to in the cycle before, or -1
        self._dacs = [self._sends(Dac, joint) for joint in JOINTS]
        self._measures: list[Measure | None] = [None] * len(JOINTS)
        self._coarse: list[int | None] = [None] * len(JOINTS)
        self._script = self._all_joints()
        for joint in JOINTS:
            self._hears(Measure, joint, partial(self._on_measure, joint - 1))
            self._hears(Reference, joint, partial(self._on_reference, joint - 1))

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Begin the next cycle."""
        if self._deadline_ns is None or now_ns < self._deadline_ns:
            return NOTHING
        self._deadline_ns = now_ns + self._period_ns
        command = next(self._script, None)
        if command is None:
            self.done, self._deadline_ns = True, None
            return NOTHING
        self._cycle += 1
        joint, code = command
        pulsed = -1 if code is None else joint
        if pulsed not in (-1, self._pulsed):
            self._out.append(self._nmt.frame(Command.RESET, 0, 0))
        self._pulsed = pulsed
        self._out.append(
            self._sync.frame(self._cycle, NodeState.HOMING, NO_SET, self.wire.dbc_hash)
        )
        if code is not None:
            self.largest_code = max(self.largest_code, abs(code))
            self._out.append(self._dacs[joint].frame(code, 0, self._cycle & 0xFF))
        if self._cycle % HEARTBEAT_EVERY == 0:
            self._beat(NodeState.HOMING)
        return self._flush()

    def next_deadline_ns(self) -> int | None:
        """When the next SYNC is due."""
        return self._deadline_ns

    @property
    def heard(self) -> bool:
        """Whether every board has answered."""
        return None not in self._measures and None not in self._coarse

    # --- the sequence, a cycle at a time: the joint, and its code or None -----------------------

    def _all_joints(self) -> Iterator[tuple[int, int | None]]:
        rested = 0
        while rested < REST_CYCLES:
            rested += self.heard
            yield 0, None
        for joint in range(len(JOINTS)):
            yield from self._one_joint(joint)

    def _one_joint(self, joint: int) -> Iterator[tuple[int, int | None]]:
        """Pulses in either direction, stronger until the motion is detected."""
        towards = 1 if self._arm.drives[joint].gear_ratio > 0.0 else -1
        finding = Finding(joint + 1, 0, 0.0, 0.0, 0.0)
        for level in LEVELS:
            displacements: list[tuple[float, float, float]] = []
            for sign in (towards, -towards):
                yield from self._pulse(joint, sign * level, displacements)
            encoder, tachometer, coarse = (
                there - back for there, back in zip(*displacements, strict=True)
            )
            finding = Finding(joint + 1, level, encoder, tachometer, coarse)
            if max(abs(encoder), abs(tachometer), abs(coarse)) >= DETECTABLE:
                break
        self.findings.append(finding)

    def _pulse(
        self, joint: int, code: int, displacements: list[tuple[float, float, float]]
    ) -> Iterator[tuple[int, int | None]]:
        """One pulse and the rest after it; appends the displacement by each sensor."""
        scale = self._arm.board_scale(joint)
        per_rad = self._arm.drives[joint].counts_per_radian
        counts, coarse = self._counts(joint), self._coarse[joint] or 0
        by_tachometer = 0.0
        for cycle in range(PULSE_CYCLES + REST_CYCLES):
            displacement = (self._counts(joint) - counts) / per_rad
            pulses = cycle < PULSE_CYCLES and abs(displacement) < MAX_DISPLACEMENT
            yield joint, code if pulses else 0 if cycle < PULSE_CYCLES + 1 else None
            measure = self._measures[joint]
            if measure is not None:
                speed = measure.velocity_adc * scale.speed_per_adc_code
                by_tachometer += speed * self._period_ns * 1e-9
        by_encoder = (self._counts(joint) - counts) / per_rad
        by_coarse = ((self._coarse[joint] or 0) - coarse) * scale.angle_per_coarse_code
        self.largest_displacement = max(self.largest_displacement, abs(by_encoder), abs(by_coarse))
        displacements.append((by_encoder, by_tachometer, by_coarse))

    def _counts(self, joint: int) -> int:
        measure = self._measures[joint]
        return 0 if measure is None else measure.counts

    def _on_measure(self, joint: int, measure: Measure) -> None:
        self._measures[joint] = measure

    def _on_reference(self, joint: int, reference: Reference) -> None:
        self._coarse[joint] = reference.coarse_adc
