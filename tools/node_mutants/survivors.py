"""Why the suite does not kill a mutant, and why the master does not stop one: by their names."""

from typing import Final

EQUIVALENT: Final = "equivalent"
"""On the bus it does what the code as it is does: to the frame, or to less than a count."""
GAP: Final = "gap"
"""It does not, and no check asks."""

SURVIVED_FOR: Final[dict[str, tuple[str, str]]] = {
    "kinematics/limits.py:34:20 boundary lower <= angle < upper": (
        EQUIVALENT,
        "an angle equal to the bound to the last bit of binary64; the next pose in float32 is not",
    ),
    "setpoint/blend.py:133:47 constant (-1.0)": (
        EQUIVALENT,
        "only BLEND reads the match, and only START and BLEND come before it: START sets it",
    ),
    "setpoint/joint.py:102:8 deletion pass": (
        EQUIVALENT,
        "only BLEND reads the match, and only START and BLEND come before it: START sets it",
    ),
    "setpoint/joint.py:100:33 constant 1": (
        EQUIVALENT,
        "t_acc before is read as its quarter, whole: 0 of 1 period as of none",
    ),
    "setpoint/joint.py:101:25 constant 1.0": (
        EQUIVALENT,
        "after an NMT START the first set-point is IDLE, START or a Cartesian line: each sets it",
    ),
    "setpoint/joint.py:160:82 constant 1.0": (
        EQUIVALENT,
        "without a second pose nothing but whether it is finite is asked of its angle",
    ),
    "wire/configuration.py:84:55 constant (-1)": (
        EQUIVALENT,
        "the last of one unpacked number is the first",
    ),
    "wire/protection.py:194:42 branch True": (
        EQUIVALENT,
        "why a frame was refused is counted for people at the node; HEARTBEAT has the sum",
    ),
    "wire/protection.py:192:12 deletion pass": (
        EQUIVALENT,
        "frames that were missed are counted for people at the node, not on the bus",
    ),
    "wire/protection.py:201:8 deletion pass": (
        EQUIVALENT,
        "refusals of one message are counted for the master, which asks its own receivers",
    ),
    "joint_nodes/controller.py:415:11 branch False": (
        EQUIVALENT,
        "terms are recorded for tools alone",
    ),
    "joint_nodes/joint.py:103:8 deletion pass": (
        EQUIVALENT,
        "terms are recorded for tools alone",
    ),
    "setpoint/history.py:117:32 swap min(2, count - 1)": (
        EQUIVALENT,
        "the lesser of two is the same in any order",
    ),
    "setpoint/history.py:86:11 swap min(LONG, max(acceleration_ticks // 2, SHORTEST))": (
        EQUIVALENT,
        "the lesser of two is the same in any order",
    ),
    "joint_nodes/friction.py:131:15 swap max(self._full_speed, moving)": (
        EQUIVALENT,
        "the larger of two is the same in any order",
    ),
    "wire/protection.py:195:19 return None": (
        EQUIVALENT,
        "None is as false as False",
    ),
    "wire/protection.py:210:19 return None": (
        EQUIVALENT,
        "None is as false as False",
    ),
    "joint_nodes/controller.py:367:19 return None": (
        EQUIVALENT,
        "None is as false as False",
    ),
    "kinematics/limits.py:27:11 boundary -math.inf <= ahead < math.inf": (
        EQUIVALENT,
        "an angle that is infinite fails the other comparison",
    ),
    "joint_nodes/field_node.py:266:12 arithmetic self.ignored['SYNC with another DBC'] -= 1": (
        EQUIVALENT,
        "what is ignored is counted for people at the node, not on the bus",
    ),
    "joint_nodes/joint.py:68:15 branch True": (
        EQUIVALENT,
        "its own ERROR is registered again, as that of a second node",
    ),
    "wire/protection.py:192:32 constant 0": (
        EQUIVALENT,
        "frames that were missed are counted for people at the node, not on the bus",
    ),
    "joint_nodes/homing.py:119:12 deletion pass": (
        GAP,
        "no check lets a homing joint stand or search too long: 23 waits",
    ),
    "joint_nodes/homing.py:147:52 arithmetic cycles / period": (
        GAP,
        "the value of EMCY where homing takes too long: 23 waits",
    ),
    "DAC codes are cut, not rounded": (
        GAP,
        "DAC may be off by one code",
    ),
}

MISSED: Final[dict[str, str]] = {}
