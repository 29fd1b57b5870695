"""Mutants of kinematics, set-point and wire that do on the bus what the code as it is does: why.

Families, as the operators make them: with another sample others of a family are drawn.
"""

from typing import Final

SAME_FOR: Final[dict[str, tuple[str, ...]]] = {
    "the bound of the master's own solutions: joints take WRIST_BOUND": (
        "kinematics/closed_form.py:31:27 constant 1.0000001",
        "kinematics/closed_form.py:31:27 constant (-0.9999999)",
        "kinematics/closed_form.py:31:27 constant 2e-07",
        "kinematics/closed_form.py:31:27 constant 0.0",
    ),
    "the tolerance of the master's own solutions: joints take WIRE": (
        "kinematics/closed_form.py:50:31 constant 1.000000001",
        "kinematics/closed_form.py:50:31 constant (-0.999999999)",
        "kinematics/closed_form.py:50:31 constant 2e-09",
        "kinematics/closed_form.py:50:31 constant 0.0",
        "kinematics/closed_form.py:50:43 constant 1.000000001",
        "kinematics/closed_form.py:50:43 constant (-0.999999999)",
        "kinematics/closed_form.py:50:43 constant 2e-09",
        "kinematics/closed_form.py:50:43 constant 0.0",
    ),
    "a joint has its own range as that of all six": (
        "kinematics/joint_solver.py:31:48 constant 2",
    ),
    "rho2 is a sum of squares: the same in any order": (
        "kinematics/joint_solver.py:75:18 swap form.triangle(pz, v114, configuration[1])",
        "kinematics/joint_solver.py:80:21 swap form.triangle(t6[11], form.v114(t6, "
        "configuration[0]), configuration[1])",
        "kinematics/joint_solver.py:102:21 swap form.triangle(pz, v114, up)",
    ),
    "theta3 has the square of V114: left and right are the same": (
        "kinematics/joint_solver.py:80:63 constant 1",
        "kinematics/joint_solver.py:80:63 constant (-1)",
    ),
    "a hypotenuse is the same in any order": (
        "kinematics/closed_form.py:82:18 swap math.hypot(self.d4, self.a3)",
    ),
    "turned by round(less than half a turn), which is 0, to the same angle": (
        "kinematics/limits.py:25:7 branch False",
        "kinematics/limits.py:25:7 sign (PI)",
    ),
    "half a turn rounds to 0 turns, as halves round to even: the same angle": (
        "kinematics/limits.py:25:7 boundary -PI < ahead <= PI",
        "kinematics/limits.py:25:7 boundary -PI <= ahead < PI",
    ),
    "an angle at the bound goes on to the same angle below": (
        "kinematics/limits.py:25:30 boundary lower < angle <= upper",
        "kinematics/limits.py:25:30 boundary lower <= angle < upper",
    ),
    "an angle that is infinite fails the other comparison": (
        "kinematics/limits.py:27:11 boundary -math.inf <= ahead < math.inf",
        "kinematics/limits.py:27:11 boundary -math.inf < ahead <= math.inf",
    ),
    "an angle at the bound is turned by ceil(0), not at all": (
        "kinematics/limits.py:30:7 boundary angle >= upper",
        "kinematics/limits.py:32:9 boundary angle <= lower",
    ),
    "an angle equal to the bound to the last bit of binary64; the next pose in float32 is not": (
        "kinematics/limits.py:34:20 boundary lower < angle <= upper",
        "kinematics/limits.py:34:20 boundary lower <= angle < upper",
    ),
    "only BLEND reads the match, and only START and BLEND come before it: START sets it": (
        "setpoint/blend.py:133:37 constant 1.0",
        "setpoint/blend.py:133:37 constant (-1.0)",
        "setpoint/blend.py:133:42 constant 1.0",
        "setpoint/blend.py:133:42 constant (-1.0)",
        "setpoint/blend.py:133:47 constant 1.0",
        "setpoint/blend.py:133:47 constant (-1.0)",
        "setpoint/blend.py:133:52 constant 1.0",
        "setpoint/blend.py:133:52 constant (-1.0)",
        "setpoint/joint.py:102:8 deletion pass",
    ),
    "does not travel, and no joint reads it": (
        "setpoint/cartesian.py:46:15 constant 1",
        "setpoint/cartesian.py:46:15 constant (-1)",
        "setpoint/cartesian.py:47:15 constant 1.0",
        "setpoint/cartesian.py:47:15 constant (-1.0)",
    ),
    "no joint reads it": (
        "setpoint/cartesian.py:48:20 constant 1",
        "setpoint/cartesian.py:48:20 constant (-1)",
    ),
    "NMT START sets it before the first set-point": (
        "setpoint/joint.py:86:55 constant 1.0",
        "setpoint/joint.py:86:55 constant (-1.0)",
    ),
    "multiplied with theta_BC, which is 0 until START, which sets both": (
        "setpoint/joint.py:98:33 constant 1.0",
        "setpoint/joint.py:98:33 constant (-1.0)",
    ),
    "t_acc before is read as its quarter, whole: at most 10 samples, as of none": (
        "setpoint/joint.py:99:24 constant 1",
        "setpoint/joint.py:99:24 constant (-1)",
    ),
    "one more than there are samples since NMT START: all of them": (
        "setpoint/joint.py:100:33 constant 1",
    ),
    "after NMT START the first set-point is IDLE, START or a Cartesian line: each sets it": (
        "setpoint/joint.py:101:25 constant 1.0",
        "setpoint/joint.py:101:25 constant (-1.0)",
    ),
    "without a second pose nothing but whether it is finite is asked of its angle": (
        "setpoint/joint.py:160:82 constant 1.0",
        "setpoint/joint.py:160:82 constant (-1.0)",
    ),
    "a distance of 1e-6 rad to the last bit of binary64: no r in float32 makes it": (
        "setpoint/joint.py:239:35 boundary abs(self.theta - base) < HELD_TOLERANCE",
    ),
    "taken back by no time: the same": ("setpoint/joint.py:259:11 branch True",),
    "at rest there are at least as many samples since the last transition": (
        "setpoint/joint.py:284:16 constant 2",
        "setpoint/joint.py:284:16 constant 0",
    ),
    "the last of one unpacked number is the first": ("wire/configuration.py:84:55 constant (-1)",),
    "no counter is negative": ("wire/protection.py:29:15 constant 2",),
    "any bit above those of a counter": ("wire/protection.py:31:22 constant 512",),
    "a sender's message is asked by tests alone": ("wire/protection.py:58:8 deletion pass",),
    "all that a joint sends is protected": (
        "wire/protection.py:67:11 branch True",
        "wire/protection.py:78:11 branch True",
    ),
    "the same frame decoded once more": (
        "wire/protection.py:106:11 branch True",
        "wire/protection.py:108:12 deletion pass",
    ),
    "frames that were missed, and leaps, are counted for people at the node": (
        "wire/protection.py:154:33 constant 1",
        "wire/protection.py:154:33 constant (-1)",
    ),
    "the first stray after it begins a row whatever it is": (
        "wire/protection.py:163:23 constant 1",
        "wire/protection.py:163:23 constant (-1)",
        "wire/protection.py:163:8 deletion pass",
    ),
    "a row of none goes on with 1 as it begins with 1": (
        "wire/protection.py:164:41 sign (1)",
        "wire/protection.py:164:42 constant 2",
        "wire/protection.py:164:42 constant 0",
    ),
    "the same frame is asked of the decoder, which keeps it": (
        "wire/protection.py:170:35 branch False",
    ),
    "the next counter is taken before, but for the second frame, which is taken whatever it is": (
        "wire/protection.py:191:11 constant 1",
    ),
    "frames that were missed are counted for people at the node, not on the bus": (
        "wire/protection.py:192:12 arithmetic self.lost -= step - 1",
        "wire/protection.py:192:12 deletion pass",
        "wire/protection.py:192:25 arithmetic step + 1",
        "wire/protection.py:192:32 constant 2",
        "wire/protection.py:192:32 constant 0",
    ),
    "why a frame was refused is counted for people at the node; HEARTBEAT has the sum": (
        "wire/protection.py:194:42 branch False",
        "wire/protection.py:194:42 branch True",
    ),
    "refusals of one message are counted for the master, which asks its own receivers": (
        "wire/protection.py:201:8 arithmetic self.bad[reason] -= 1",
        "wire/protection.py:201:8 deletion pass",
        "wire/protection.py:201:28 constant 2",
        "wire/protection.py:201:28 constant 0",
    ),
    "the next stray after a leap begins a row: it is not beside the counter before it": (
        "wire/protection.py:211:37 constant 1",
        "wire/protection.py:211:37 constant (-1)",
    ),
    "leaps are counted for people at the node, not on the bus": (
        "wire/protection.py:212:8 arithmetic self.leaps -= 1",
        "wire/protection.py:212:8 deletion pass",
        "wire/protection.py:212:22 constant 2",
        "wire/protection.py:212:22 constant 0",
    ),
    "the lesser of two is the same in any order": (
        "setpoint/history.py:117:32 swap min(2, count - 1)",
        "setpoint/history.py:86:11 swap min(LONG, max(acceleration_ticks // 2, SHORTEST))",
    ),
    "None is as false as False": (
        "wire/protection.py:195:19 return None",
        "wire/protection.py:210:19 return None",
    ),
}
"""Reasons, and the names of the mutants."""
