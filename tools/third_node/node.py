"""The whole joint: its set-point, ERROR and torque in OPERATIONAL (docs/node.md, A cycle)."""

import copy

from third_node import kinematics
from third_node.codec import float32
from third_node.faults import ERROR_MISSING, FOLLOWING_ERROR, SETPOINT_MISSING, SETPOINT_STEP
from third_node.joint import Joint
from third_node.life import MASTER, OPERATIONAL
from third_node.setpoint import SetPoint
from third_node.speaker import OF_SETPOINT

SETPOINT_1, SETPOINT_2, COMPLY, JOINT_SETPOINT_1, JOINT_SETPOINT_2, BIAS = OF_SETPOINT
RATE_STEP, IN_A_ROW = 0.2, 4  # of SPEED_LIMIT; set-points before it
WITH_COMPLY, WITH_BIAS, WITH_ANGLES = 1, 2, 4  # bits of extras


class Node(Joint):
    """A joint, from its number and what it drew at power-on."""

    def is_whole(self) -> bool:
        """Whether all is here that SETPOINT_1 says belongs to it."""
        parts = self.parts
        if SETPOINT_1 not in parts:
            return False
        extras, two = parts[SETPOINT_1]["extras"], parts[SETPOINT_1]["poses"] == 2
        needed = {
            SETPOINT_2: (True, two),
            COMPLY: (extras & WITH_COMPLY, True),
            BIAS: (extras & WITH_BIAS, True),
            JOINT_SETPOINT_1: (extras & WITH_ANGLES, True),
            JOINT_SETPOINT_2: (extras & WITH_ANGLES, two),
        }
        here = all((frame in parts) == want for frame, (asked, want) in needed.items() if asked)
        return here and extras < 2 * WITH_ANGLES

    def go_on(self) -> None:
        """Do what can be done with what has come in."""
        if self.state != OPERATIONAL:
            return
        if self.sampled and not self.error_sent and self.is_whole():
            new = self.new_setpoint()
            if new is not None:
                self.take_setpoint(new)
        if self.state == OPERATIONAL and len(self.errors) == 6 and not self.servoed:
            self.servoed = True
            self.ladder[ERROR_MISSING] = 0
            six = [self.errors[j] for j in range(1, 7)]
            columns = [[told[i] for told in six] for i in range(3)]
            speeds = (self.setpoint.rate, self.speed, self.cycle)
            torque = self.law.servo(self.rows, columns, *speeds, self.bias)
            self.watch_stall()
            self.send_dac(torque, self.bias)

    def new_setpoint(self) -> SetPoint | None:
        """The set-point's memory after this cycle, or None if it is refused."""
        first = self.parts[SETPOINT_1]
        state, mode, p = first["state"], first["mode"], first["blend_p"]
        two = first["poses"] == 2
        old = self.setpoint
        if first["extras"] & WITH_ANGLES:
            self.hold_told(two)
        q1 = self.solve(SETPOINT_1, JOINT_SETPOINT_1, old.previous_of_q1(state, mode))
        q2 = None
        if two:
            q2 = self.solve(SETPOINT_2, JOINT_SETPOINT_2, old.previous_of_q2())
        if q1 is None or (two and q2 is None) or not old.may_follow(state, mode, p, two):
            return None
        new = copy.deepcopy(old)
        new.step(first, q1, q2)
        return new

    def hold_told(self, two: bool) -> None:
        """Bit 3 of JOINT_SETPOINT: theta4 while the wrist is straight."""
        for frame in (JOINT_SETPOINT_1, JOINT_SETPOINT_2)[: 1 + two]:
            if self.parts[frame]["joints"] & 8:
                self.held.set_angle(self.parts[frame]["joint_4"])

    def solve(self, pose_id: int, told_id: int, previous: float) -> float | None:
        """The joint's angle of one pose, rad."""
        p = self.p
        bounds = (p.POSITION_MIN, p.POSITION_MAX)
        if self.parts[SETPOINT_1]["extras"] & WITH_ANGLES:
            told = self.parts[told_id]
            if told["joints"] >> (self.joint - 1) & 1:
                return kinematics.told(told[f"joint_{self.joint}"], *bounds)
        if p.KINEMATICS == 0:
            return None
        pose = self.parts[pose_id]
        o, a, at = ([pose[f"{v}_{axis}"] for axis in "xyz"] for v in "oap")
        code = pose["configuration"]
        angle = kinematics.solve(self.joint, p.geometry, o, a, at, code, self.held)
        return None if angle is None else kinematics.nearest_turn(angle, previous, *bounds)

    def take_setpoint(self, new: SetPoint) -> None:
        """The own error; ERROR goes out, unless the joint has to stop."""
        extras = self.parts[SETPOINT_1]["extras"]
        comply = self.parts[COMPLY][f"joint_{self.joint}"] if extras & WITH_COMPLY else 0.0
        theta_d = new.theta + comply
        error = theta_d - self.theta
        rate = new.rate - self.speed
        if self.rows.selection == 0:
            rate += (comply - self.comply_before) / self.p.PERIOD
            if self.runs_away(error, self.theta):
                return
        jump = theta_d - self.theta_d
        bound = self.step_bound * (1 + self.held_cycles)
        told = (float32(error), float32(rate), float32(new.acceleration))
        fits = abs(told[0]) <= 2 and abs(told[1]) <= 100 and abs(told[2]) <= 10000
        change, most = new.rate - self.setpoint.rate, RATE_STEP * self.p.SPEED_LIMIT
        if abs(jump) <= bound and self.taken >= IN_A_ROW and abs(change) > most:
            self.trip(SETPOINT_STEP, MASTER, SETPOINT_1, change, most)
            return
        if abs(jump) > bound or not fits:
            self.trip(SETPOINT_STEP, MASTER, SETPOINT_1, jump, bound)
            return
        if self.rows.selection != 0:
            self.ladder[FOLLOWING_ERROR] = 0
        elif not self.follows(self.following.excess(error, rate)):
            return
        self.setpoint = new
        self.theta_d = theta_d
        self.comply_before = comply
        self.held_cycles = 0
        self.taken += 1
        own = self.parts[BIAS][f"torque_{self.joint}"] if extras & WITH_BIAS else 0.0
        self.bias = self.law.cut_bias(own)
        fields = {"error": error, "error_rate": rate, "acceleration": new.acceleration}
        self.send(self.id_error, {**fields, "cycle": self.cycle & 0xFF})
        self.error_sent = True
        self.ladder[SETPOINT_MISSING] = 0
        self.errors[self.joint] = (error, rate, new.acceleration)
