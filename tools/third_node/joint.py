"""A joint's cycle: SYNC, MEASURE, REFERENCE, what is missing (docs/node.md, node-detectors.md)."""

from third_node import kinematics
from third_node.codec import Fields
from third_node.detectors import (
    implausible,
)
from third_node.faults import (
    ERROR_MISSING,
    FOLLOWING_ERROR,
    HOMING_FAILED,
    MEASURE_MISSING,
    OVERLOAD,
    ROWS_IMPLAUSIBLE,
    ROWS_MISSING,
    RUNAWAY,
    SETPOINT_MISSING,
    STALL,
)
from third_node.law import Law, Rows
from third_node.life import (
    FAULT,
    HOMING,
    MASTER,
    OPERATIONAL,
    QUICKSTOP,
    READY,
)
from third_node.sampling import Sampling
from third_node.setpoint import SetPoint
from third_node.speaker import ESTOP, OF_SETPOINT

SETPOINT_1 = OF_SETPOINT[0]
MOST_SKIPPED = 4
HARD_MARGIN, SOFT_MARGIN = 0.05, 0.02  # of the range, rad


class Joint(Sampling):
    """A joint, from its number and what it drew at power-on."""

    def __init__(self, joint: int, boot_id: int = 1) -> None:
        super().__init__(joint, boot_id)
        self.rows = Rows(joint)
        self.waiting: Rows | None = None
        self.sample_cycle = 0  # DAC is tagged with it
        self.lost = 0  # of them those that the watchdog told of
        self.last_k = -1  # number of the last SYNC since START
        self.torque = self.sent_bias = self.bias = 0.0
        self.forget_cycle(False, False)
        self.forget_setpoint()

    # --- a configuration, and states

    def on_new_set(self) -> None:
        """All parts of a joint."""
        p = self.config.values
        assert p is not None
        self.begin_sampling(p)
        self.law = Law(self.joint, p)
        self.held = kinematics.Held()
        self.setpoint = SetPoint(p.PERIOD, 0.0)
        self.rows, self.waiting = Rows(self.joint), None
        self.lost, self.last_k = 0, -1

    def on_void_set(self) -> None:
        """The reference goes with the configuration: ``on_new_set`` makes all new."""

    def on_state(self, event: str) -> None:
        """What begins with a state."""
        self.ramps = False
        if event == "PREOP":
            self.rows, self.waiting = Rows(self.joint), None
            self.forget_cycle(False, False)
        elif event == "HOME":
            self.law.reset()
            self.runaway.reset()
            self.homing.begin()
        elif event == "START":
            self.law.reset()
            self.runaway.reset()
            self.forget_setpoint()
            self.forget_cycle(False, False)
            self.last_k = -1
        else:
            self.begin_stop(self.theta_d, self.setpoint.rate)
            if self.sampled:
                self.owes_dac = False  # the stop begins with the next sample

    def drives(self) -> bool:
        """Whether homing, or the hold after it, drives the joint."""
        return self.state in (HOMING, READY) and self.sync_state == HOMING

    def is_driven(self) -> bool:
        """Whether DAC goes out."""
        return self.drives() or self.state in (OPERATIONAL, QUICKSTOP) or self.damps()

    def send_zero(self) -> None:
        """One DAC 0."""
        self.law.terms = {}
        self.send_dac(0.0)

    def send_dac(self, torque: float, bias: float = 0.0) -> None:
        """DAC, Nm."""
        self.torque, self.sent_bias = torque, bias
        current, force = self.law.codes(torque, bias)
        self.amplifier.drive(current, force)
        fields = {"current_dac": current, "force_dac": force, "cycle": self.sample_cycle}
        self.send(self.id_dac, fields)
        self.owes_dac = False

    # --- a cycle

    def forget_cycle(self, owes_dac: bool, expects_setpoint: bool) -> None:
        """Nothing of the cycle has come in."""
        self.parts: dict[int, Fields] = {}  # frames of the set-point
        self.sampled = False
        self.error_sent = False
        self.errors: dict[int, tuple[float, float, float]] = {}
        self.servoed = False
        self.owes_dac = owes_dac
        self.expects_setpoint = expects_setpoint

    def on_cycle(self, fields: Fields, was_driven: bool) -> None:
        """SYNC: the cycle before is judged, a new one begins."""
        if not self.config.values:
            return
        self.heat_up(was_driven)
        if not self.drives():
            self.homing.let_go()
        self.judge()
        k = fields["cycle"]
        gap = self.gap(k)
        self.unsampled += max(gap - self.lost, 1)
        self.last_k, self.lost = k, 0
        if self.state == OPERATIONAL:
            for _ in range(gap - 1):
                self.hold_setpoint()
        self.take_up_rows(fields["row_set"])
        owes = self.state in (OPERATIONAL, QUICKSTOP)
        listens = self.state in (HOMING, QUICKSTOP) or self.damps()
        self.forget_cycle(owes, listens and self.sync_state == OPERATIONAL)

    def on_lost_sync(self) -> None:
        """The cycle before is judged; what comes next belongs to none."""
        if not self.config.values:
            return
        self.heat_up(self.is_driven())
        self.judge()
        self.unsampled += 1
        self.lost += 1
        self.forget_cycle(False, False)

    def gap(self, k: int) -> int:
        """Cycles from the last SYNC to this one, 0 where it goes back."""
        if self.last_k < 0:
            return min(k + 1, MOST_SKIPPED)
        ahead = (k - self.last_k) % 2**32
        return min(ahead, MOST_SKIPPED) if ahead < 2**31 else 0

    def heat_up(self, driven: bool) -> None:
        """The motor has borne the torque of a cycle."""
        if self.motor.overheats(self.torque + self.sent_bias if driven else 0.0):
            numbers = (self.motor.heat, self.motor.bound)
            self.trip(OVERLOAD, self.joint, self.id_measure, *numbers)

    def judge(self) -> None:
        """What the cycle before lacked."""
        if self.owes_dac:
            if not self.sampled:
                self.count(MEASURE_MISSING, self.source(), self.id_measure)
            elif not self.error_sent:
                self.count(SETPOINT_MISSING, MASTER, SETPOINT_1)
            else:
                silent = [j for j in range(1, 7) if j not in self.errors]
                if silent:
                    self.count(ERROR_MISSING, silent[0], 0x200 + silent[0])
                return
            self.hold_setpoint()
        elif self.expects_setpoint:
            if SETPOINT_1 in self.parts:
                self.ladder[SETPOINT_MISSING] = 0
            else:
                self.count(SETPOINT_MISSING, MASTER, SETPOINT_1)

    def hold_setpoint(self) -> None:
        """A cycle without a set-point."""
        self.setpoint.hold()
        self.held_cycles += 1
        self.taken = 0

    def take_up_rows(self, number: int) -> None:
        """The rows that SYNC names act from now on, if they are here."""
        if number != self.rows.set:
            if self.waiting is None or self.waiting.set != number:
                self.count(ROWS_MISSING, MASTER, self.id_rows)
                return
            excess = implausible(self.p, self.joint, self.waiting, self.rows)
            if excess is not None:
                self.count(ROWS_IMPLAUSIBLE, MASTER, self.id_rows, *excess)
                return
            self.rows = self.waiting
        self.ladder[ROWS_MISSING] = self.ladder[ROWS_IMPLAUSIBLE] = 0

    def on_frame_of_joint(self, can_id: int, fields: Fields) -> None:
        """A frame of the cycle, or ROWS."""
        if can_id == self.id_rows:
            self.waiting = Rows(self.joint, fields)
            return
        if not self.config.values:
            return
        of_this_cycle = (fields["cycle"] - self.cycle) % 256 == 0
        if can_id == self.id_measure:
            if of_this_cycle or self.state in (QUICKSTOP, FAULT):
                self.on_measure(fields)
        elif not of_this_cycle:
            return
        elif can_id == self.id_reference:
            self.on_reference(fields)
        elif can_id in OF_SETPOINT:
            self.parts[can_id] = fields
            self.go_on()
        else:
            told = (fields["error"], fields["error_rate"], fields["acceleration"])
            self.errors[can_id - 0x200] = told
            self.go_on()

    # --- MEASURE

    def source(self) -> int:
        """Who has the sensors."""
        return int(self.p.SENSOR_SOURCE)

    def sender_of(self, can_id: int) -> int:
        """Whose frame it is."""
        if can_id in (self.id_measure, self.id_reference):
            return self.source()
        if can_id in self.own:
            return self.joint
        if 0x201 <= can_id <= 0x206:
            return can_id - 0x200
        return 0 if can_id == ESTOP else MASTER

    def on_measure(self, fields: Fields) -> None:
        """The sample, and what it leads to."""
        self.sampled = True
        self.sample_cycle = fields["cycle"]
        self.ladder[MEASURE_MISSING] = 0
        self.take_sample(fields)
        if self.state == OPERATIONAL:
            self.go_on()
        elif self.state == QUICKSTOP:
            self.follow_ramp()
        elif self.damps():
            self.send_dac(self.law.damped(self.rows, self.speed))

    # --- the stop, homing

    def follow_ramp(self) -> None:
        """A sample in QUICKSTOP."""
        stop = self.stopping
        assert stop is not None
        self.ramps = True
        stop.ramp(self.theta)
        error = stop.position - self.theta
        if self.runs_away(error, self.theta):
            return
        if not self.follows(self.following.excess_of_stop(error, self.speed)):
            return
        inertia = self.rows.inertia[self.joint - 1] * stop.acceleration
        rest = (stop.speed - self.speed, self.rows.gravity, stop.speed, inertia)
        torque = self.law.alone(error, *rest)
        self.watch_stall()
        self.send_dac(torque)

    def follows(self, excess: tuple[float, float] | None) -> bool:
        """Whether the joint follows well enough to go on."""
        before = self.state
        if excess is None:
            self.ladder[FOLLOWING_ERROR] = 0
        else:
            self.count(FOLLOWING_ERROR, self.joint, self.id_measure, *excess)
        return self.state == before

    def watch_stall(self) -> None:
        """After a torque of servo or stop ramp: a joint must not stand at its limit for long."""
        if self.motor.stalls(self.law.cut, self.speed):
            numbers = (self.motor.run * self.p.PERIOD, self.p.STALL_TIME)
            self.trip(STALL, self.joint, self.id_measure, *numbers)

    def runs_away(self, error: float, angle: float) -> bool:
        """Whether the torque had to go off."""
        if not self.runaway.watch(error, angle):
            return False
        self.trip(RUNAWAY, self.joint, self.id_measure, error, self.runaway.bound)
        return True

    def on_reference(self, fields: Fields) -> None:
        """Homing, or the hold."""
        if not self.drives() or not self.sampled:
            return
        homing = self.homing
        if homing.target is None:  # the joint was not driven until now
            self.law.reset()
            self.runaway.reset()
        homing.step(self.counts, fields, self.law.cut)
        torque = homing.torque(self.law, self.rows.gravity, self.speed)
        if homing.failure is not None:
            value, bound, stands = homing.failure
            frame = self.id_measure if stands else self.id_reference
            self.trip(HOMING_FAILED, self.joint, frame, value, bound)
            return
        ends = self.state == HOMING and homing.found
        if ends:
            self.runaway.reset()
            self.theta = homing.theta
        if self.runs_away(homing.error, homing.theta):
            return
        if ends:
            self.state = READY
        self.send_dac(torque)

    # --- the set-point

    def go_on(self) -> None:
        """Do what can be done with what has come in."""
        raise NotImplementedError

    def forget_setpoint(self) -> None:
        """START."""
        self.setpoint = SetPoint(self.setpoint.tau, self.theta)
        self.theta_d = self.theta
        self.comply_before = 0.0
        self.held_cycles = 0
        self.taken = 0  # set-points in a row
        self.bias = 0.0
