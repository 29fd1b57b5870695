"""What a joint believes of its sample (docs/node-detectors.md, The sample; node.md, Trust)."""

from third_node.codec import Fields
from third_node.configuration import Parameters
from third_node.detectors import (
    RAILS,
    Amplifier,
    Following,
    Motor,
    Tachometer,
    rest_of,
    stop_begin,
)
from third_node.faults import (
    ADC_SATURATED,
    AMPLIFIER_FAULT,
    ENCODER_GLITCH,
    HARD_LIMIT,
    OVERSPEED,
    SENSOR_MISMATCH,
    SENSOR_STUCK,
    SOFT_LIMIT,
)
from third_node.homing import Homing
from third_node.life import MASTER, OPERATIONAL, QUICKSTOP, Life
from third_node.setpoint import SetPoint
from third_node.speaker import OF_SETPOINT
from third_node.stop import Runaway, Stop

SETPOINT_1 = OF_SETPOINT[0]
HARD_MARGIN, SOFT_MARGIN = 0.05, 0.02  # of the range, rad


class Sampling(Life):
    """Angle and speed of a joint, and the stop that begins where it is."""

    def __init__(self, joint: int, boot_id: int) -> None:
        super().__init__(joint, boot_id)
        self.counts = 0
        self.theta = self.speed = 0.0
        self.unsampled = 1  # cycles since the last sample
        self.theta_d = 0.0  # commanded, the displacement included
        self.setpoint = SetPoint(1.0, 0.0)
        self.stopping: Stop | None = None
        self.ramps = False  # the stop has made a step

    def begin_sampling(self, p: Parameters) -> None:
        """A configuration is in force."""
        self.p = p
        self.homing = Homing(p, None)
        self.runaway = Runaway(p)
        self.tachometer, self.amplifier = Tachometer(p), Amplifier(p)
        self.following, self.motor = Following(p), Motor(p)
        self.step_bound = 1.5 * p.SPEED_LIMIT * p.PERIOD
        self.theta = self.speed = 0.0
        self.unsampled = 1

    def take_sample(self, fields: Fields) -> None:
        """Angle and speed, and whether they can be trusted."""
        self.counts, code = fields["counts"], fields["velocity_adc"]
        theta, v = self.homing.angle(self.counts), code * self.p.RATE_PER_CODE
        before, v_before = self.theta, self.speed
        unsampled, self.unsampled = self.unsampled, 0
        if not self.is_driven():
            self.tachometer.clear()
            self.amplifier.clear()
            self.theta, self.speed = theta, v
            return
        u = max(1, unsampled)
        bridges = self.state in (OPERATIONAL, QUICKSTOP)
        watches = bridges or self.damps()
        railed = code in RAILS
        if railed:
            v = (theta - before) / (u * self.p.PERIOD)
        if fields["braked"]:
            self.amplifier.clear()
        current = fields["current_adc"]
        passed = self.amplifier.border_passed(current)
        self.theta, self.speed = theta, v
        saturated = current if current in RAILS and passed is not None else None
        self.counts_if(ADC_SATURATED, code if railed else saturated, 2047.0)
        jumped = bridges and self.jumps(theta - before, before + v_before * self.p.PERIOD * u, u)
        if not railed and not jumped and unsampled == 1:
            self.hold_against_encoder(code, self.theta - before, v_before)
        self.counts_if(
            OVERSPEED, v if abs(v) > self.p.OVERSPEED_LIMIT else None, self.p.OVERSPEED_LIMIT
        )
        self.counts_if(AMPLIFIER_FAULT, None if passed is None else current, passed)
        if watches:
            self.check_range()

    def counts_if(self, fault: int, value: float | None, bound: float | None) -> None:
        """A cycle with a value that is beyond its bound, or without one."""
        if value is None:
            self.ladder[fault] = 0
        else:
            self.count(fault, self.joint, self.id_measure, value, bound)

    def jumps(self, jump: float, extrapolated: float, u: int) -> bool:
        """Whether the encoder steps as no joint can, after u cycles."""
        bound = self.step_bound * u
        if abs(jump) <= bound:
            self.ladder[ENCODER_GLITCH] = 0
            return False
        self.count(ENCODER_GLITCH, self.joint, self.id_measure, jump, bound)
        if self.ladder[ENCODER_GLITCH] <= 2:
            self.theta = extrapolated
        elif self.ramps and self.stopping is not None:
            self.stopping.position += self.theta - extrapolated
        else:
            self.begin_stop(self.theta, self.speed)
        return True

    def hold_against_encoder(self, code: int, moved: float, before: float) -> None:
        """What the tachometer says of a motion, rad, after a speed, rad/s."""
        tau, v, watch = self.p.PERIOD, self.speed, self.tachometer
        if watch.differs(moved, v, before):
            off = moved / tau - (v + before) / 2
            numbers = (off, self.p.TACHOMETER_LIMIT)
            self.trip(SENSOR_MISMATCH, self.joint, self.id_measure, *numbers)
        varied = watch.variation(code, moved)
        if varied > watch.most_varied:
            numbers = (varied / tau, watch.most_varied / tau)
            self.trip(SENSOR_STUCK, self.joint, self.id_measure, *numbers)

    def check_range(self) -> None:
        """The end of the range is near, or passed."""
        p = self.p
        low, high = p.POSITION_MIN - HARD_MARGIN, p.POSITION_MAX + HARD_MARGIN
        if not low <= self.theta <= high:
            self.trip(HARD_LIMIT, self.joint, 0, self.theta, low if self.theta < low else high)
            return
        rest, told = rest_of(p, self.theta, self.speed), rest_of(p, *self.commanded())
        low, high = p.POSITION_MIN - SOFT_MARGIN, p.POSITION_MAX + SOFT_MARGIN
        if not low <= rest <= high:
            inside = p.POSITION_MIN <= told <= p.POSITION_MAX
            cause = (self.joint, 0) if inside else (MASTER, SETPOINT_1)
            self.trip(SOFT_LIMIT, *cause, rest, low if rest < low else high)

    # --- the stop

    def commanded(self) -> tuple[float, float]:
        """The motion that is commanded, rad and rad/s."""
        if self.state == QUICKSTOP and self.stopping is not None:
            return self.stopping.position, self.stopping.speed
        return self.theta_d, self.setpoint.rate

    def begin_stop(self, position: float, rate: float) -> None:
        """The controlled stop of a motion that was commanded, rad and rad/s."""
        measured = (self.theta, self.speed)
        self.stopping = Stop(self.p, *stop_begin(self.p, (position, rate), measured))
        self.ramps = False
        self.following.begin_stop(self.speed)
        self.runaway.reset()
