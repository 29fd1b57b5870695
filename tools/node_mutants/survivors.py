"""Why the suite does not kill a mutant, and why the master does not stop one: by their names."""

from typing import Final

from node_mutants.equivalents import SAME_FOR

EQUIVALENT: Final = "equivalent"
"""On the bus it does what the code as it is does: to the frame, or to less than a count."""
GAP: Final = "gap"
"""It does not, and no check asks."""

SURVIVED_FOR: Final[dict[str, tuple[str, str]]] = {
    **{name: (EQUIVALENT, why) for why, names in SAME_FOR.items() for name in names},
    "joint_nodes/controller.py:415:11 branch False": (
        EQUIVALENT,
        "terms are recorded for tools alone",
    ),
    "joint_nodes/joint.py:103:8 deletion pass": (
        EQUIVALENT,
        "terms are recorded for tools alone",
    ),
    "joint_nodes/friction.py:131:15 swap max(self._full_speed, moving)": (
        EQUIVALENT,
        "the larger of two is the same in any order",
    ),
    "joint_nodes/controller.py:367:19 return None": (
        EQUIVALENT,
        "None is as false as False",
    ),
    "joint_nodes/field_node.py:266:12 arithmetic self.ignored['SYNC with another DBC'] -= 1": (
        EQUIVALENT,
        "what is ignored is counted for people at the node, not on the bus",
    ),
    "joint_nodes/joint.py:68:15 branch True": (
        EQUIVALENT,
        "its own ERROR is registered again, as that of a second node",
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
