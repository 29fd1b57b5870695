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
    "joint_nodes/controller.py:167:21 constant (-1.0)": (
        EQUIVALENT,
        "START sets the bias to 0 before any torque has one",
    ),
    "joint_nodes/controller.py:449:8 deletion pass": (
        EQUIVALENT,
        "the first cycle of homing resets the servo again, and none uses it before",
    ),
    "joint_nodes/field_node.py:265:11 branch False": (
        EQUIVALENT,
        "OFF is not harder than OFF: no EMCY, no DAC, the same bit; in INIT it hears no frame",
    ),
    "joint_nodes/field_node.py:367:42 swap ChainMap(DEFAULTS, p)": (
        EQUIVALENT,
        "no parameter of a joint has a default: it needs every one",
    ),
    "joint_nodes/friction.py:132:56 branch True": (
        EQUIVALENT,
        "RATE_PER_CODE is never 0, so neither is the speed that counts as moving",
    ),
    "joint_nodes/friction.py:135:22 constant 1.0": (
        EQUIVALENT,
        "the dither is kept for the recorded terms alone",
    ),
    "joint_nodes/friction.py:153:46 boundary change >= 0.0": (
        EQUIVALENT,
        "what is not reached differs by a step of the ramp at least, and TORQUE_LIMIT is never 0",
    ),
    "joint_nodes/friction.py:91:8 deletion pass": (
        EQUIVALENT,
        "whether it rests is set by each friction torque, and asked by the integral after it",
    ),
    "joint_nodes/homing.py:94:21 constant (-1.0)": (
        EQUIVALENT,
        "each cycle of homing sets its error before it is asked",
    ),
    "joint_nodes/ladder.py:45:35 constant 0": (
        EQUIVALENT,
        "the first step reaches a rung of none too, and its EMCY tells a bound of its own",
    ),
    "joint_nodes/servo.py:200:7 branch True": (
        EQUIVALENT,
        "no damping times finite rates is a damping of 0",
    ),
    "joint_nodes/servo.py:257:26 constant (-1.0)": (
        EQUIVALENT,
        "the friction is always given",
    ),
    "joint_nodes/servo.py:257:26 constant 1.0": (
        EQUIVALENT,
        "the friction is always given",
    ),
    "joint_nodes/servo.py:258:22 constant (-1.0)": (
        EQUIVALENT,
        "the bias is always given",
    ),
    "joint_nodes/angle_solver.py:71:28 boundary self._lower <= angle < self._upper": (
        EQUIVALENT,
        "no float32 is 1e-5 beyond another in binary64: no angle of JOINT_SETPOINT meets the bound",
    ),
}

MISSED: Final[dict[str, str]] = {}
