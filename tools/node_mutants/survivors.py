"""Why the suite does not kill a mutant, and why the master does not stop one: by their names."""

from typing import Final

EQUIVALENT: Final = "equivalent"
"""On the bus it does what the code as it is does: to the frame, or to less than a count."""
GAP: Final = "gap"
"""It does not, and no check asks."""

SURVIVED_FOR: Final[dict[str, tuple[str, str]]] = {
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
    "theta4 is held where the wrist is not straight yet": (
        GAP,
        "no pose is asked between 1e-5 and 1e-3 rad of a straight wrist",
    ),
    "DAC codes are cut, not rounded": (
        GAP,
        "DAC may be off by one code",
    ),
}

MISSED: Final[dict[str, str]] = {}
