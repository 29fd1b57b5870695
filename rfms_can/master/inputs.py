"""What a control cycle brings: samples of the plant, errors and torques of the nodes, the wrench.

Handlers take the values of good frames; an answer of another cycle is counted and has no effect.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Final

from rfms_can.master.answers import MEASURES, REFERENCES, Answers, Lost, bit
from rfms_can.master.arm_state import ArmState
from rfms_can.master.phases import Phase
from rfms_can.wire.nodes import GRIPPER, JOINTS, PLANT
from rfms_can.wire.records import Dac, Force, JointError, Measure, Reference

_JAW: Final = bit("MEASURE", GRIPPER)
_WRIST: Final = bit("FORCE", PLANT)


class CycleInputs:
    """The inputs of the cycle under way.

    Args:
        arm_state: takes the encoders.
        torque_scales: motor torque per code of the current DAC and of the fine DAC, Nm (6, 2).
        sensor: whether the plant reads a wrist sensor.
        ignored: counts answers of another cycle, by their name.
        on_sampled: called when the encoders of the whole arm have been read.
        on_complete: called when all have answered.

    Attributes:
        arm_state: the same.
        errors: joint errors, rad (6).
        torques: what the nodes have set the motors to, Nm (6).
        sampled, told: bits of the joints whose MEASURE, ERROR is of the cycle; bit 0 is joint 1.
        spoken: bits of the joints whose ERROR or DAC is: they have heard its SYNC.
        sampled_before, told_before, spoken_before: the same of the cycle before.
    """

    __slots__ = (
        "_answers",
        "_cycle",
        "_ignored",
        "_on_complete",
        "_on_sampled",
        "_reading",
        "_samples",
        "_torque_scales",
        "arm_state",
        "errors",
        "sampled",
        "sampled_before",
        "spoken",
        "spoken_before",
        "told",
        "told_before",
        "torques",
    )

    def __init__(
        self,
        arm_state: ArmState,
        torque_scales: Sequence[tuple[float, float]],
        ignored: Counter[str],
        on_sampled: Callable[[], None],
        on_complete: Callable[[], None],
        *,
        sensor: bool = False,
    ) -> None:
        self.arm_state = arm_state
        self.errors = [0.0] * len(JOINTS)
        self.torques = [0.0] * len(JOINTS)
        self.sampled = self.told = self.spoken = 0
        self.sampled_before = self.told_before = self.spoken_before = 0
        self._torque_scales = torque_scales
        self._reading: tuple[float, ...] | None = None
        self._answers = Answers(sensor=sensor)
        self._cycle = -1
        self._samples = MEASURES
        self._ignored = ignored
        self._on_sampled = on_sampled
        self._on_complete = on_complete

    def begin(self, phase: Phase, cycle: int) -> None:
        """A cycle begins: everything that its phase expects is missing."""
        self.sampled_before, self.told_before = self.sampled, self.told
        self.spoken_before = self.spoken
        self.sampled = self.told = self.spoken = 0
        self._cycle = cycle & 0xFF  # as MEASURE, ERROR and DAC carry it
        self._samples = MEASURES | REFERENCES if phase is Phase.HOME else MEASURES
        self._answers.begin(phase, cycle)

    @property
    def complete(self) -> bool:
        """Whether all have answered."""
        return not self._answers.missing

    @property
    def missing(self) -> int:
        """Bits of what has not come."""
        return self._answers.missing

    def give_up(self, cycle: int) -> tuple[str, Lost | None]:
        """The time of a cycle is over: do not wait for what is missing.

        Returns:
            Names of what is missing; which node has been silent for too long, or None.
        """
        answers = self._answers
        names, lost = answers.describe(), answers.unanswered(cycle)
        answers.missing = 0
        return names, lost

    def answered(self, answer: int) -> None:
        """Take the bit of a frame of this cycle off what is missing; the last one completes it."""
        answers = self._answers
        missing = answers.missing
        if missing:
            missing = answers.missing = missing & ~answer
            if not missing:
                self._on_complete()

    def _sampled(self, answer: int) -> None:
        if self._answers.missing & self._samples == answer:
            self._on_sampled()
        self.answered(answer)

    def take_reading(self) -> tuple[float, ...] | None:
        """The last reading of the wrist sensor, N and N m (6), once; None without a new one."""
        reading, self._reading = self._reading, None
        return reading

    # --- frames -------------------------------------------------------------------------------

    def on_measure(self, joint: int, answer: int, measure: Measure) -> None:
        """MEASURE of joint 1 to 6; ``answer`` is its bit."""
        if measure.cycle == self._cycle:
            self.arm_state.measure(joint, measure)
            self.sampled |= 1 << joint - 1
            self._sampled(answer)
        else:
            self._ignored["stale MEASURE"] += 1

    def on_reference(self, joint: int, answer: int, reference: Reference) -> None:
        """REFERENCE of joint 1 to 6."""
        if reference.cycle == self._cycle:
            self.arm_state.reference(joint, reference)
            self._sampled(answer)
        else:
            self._ignored["stale REFERENCE"] += 1

    def on_jaw(self, measure: Measure) -> None:
        """MEASURE of the gripper."""
        if measure.cycle == self._cycle:
            self.arm_state.jaw_counts = measure.counts
            self.answered(_JAW)
        else:
            self._ignored["stale MEASURE"] += 1

    def on_error(self, joint: int, answer: int, error: JointError) -> None:
        """ERROR of joint 1 to 6."""
        if error.cycle == self._cycle:
            self.errors[joint - 1] = error.error
            self.told |= 1 << joint - 1
            self.spoken |= 1 << joint - 1
            self.answered(answer)
        else:
            self._ignored["stale ERROR"] += 1

    def on_dac(self, node: int, answer: int, dac: Dac) -> None:
        """DAC of node 1 to 7."""
        if dac.cycle == self._cycle:
            if node != GRIPPER:
                self.spoken |= 1 << node - 1
                current, fine = self._torque_scales[node - 1]
                self.torques[node - 1] = current * dac.current_dac + fine * dac.force_dac
            self.answered(answer)
        else:
            self._ignored["stale DAC"] += 1

    def on_force(self, force: Force) -> None:
        """FORCE, the wrist sensor."""
        if force.cycle == self._cycle:
            self._reading = force[:6]
            self.answered(_WRIST)
        else:
            self._ignored["stale FORCE"] += 1
