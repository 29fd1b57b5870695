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
    "joint_nodes/controller.py:447:8 deletion pass": (
        EQUIVALENT,
        "the first cycle of homing resets the watch again, and none asks it before",
    ),
    "setpoint/joint.py:200:16 deletion pass": (
        GAP,
        "no trace has a START within ten periods of a Cartesian transition out of a joint segment",
    ),
    "joint_nodes/controller.py:166:48 constant (-1.0)": (
        EQUIVALENT,
        "each sample sets speed and torque, and homing the angle, before they are asked",
    ),
    "joint_nodes/field_node.py:292:36 constant 0": (
        EQUIVALENT,
        "what is ignored is counted for people at the node, not on the bus",
    ),
    "joint_nodes/field_node.py:163:8 deletion pass": (
        EQUIVALENT,
        "only SYNC asks the time, and brings its own",
    ),
    "joint_nodes/field_node.py:287:63 constant 0": (
        EQUIVALENT,
        "what is ignored is counted for people at the node, not on the bus",
    ),
    "kinematics/closed_form.py:102:37 boundary squared >= 0.0": (
        EQUIVALENT,
        "the root of 0 is 0",
    ),
    "joint_nodes/controller.py:168:8 deletion pass": (
        EQUIVALENT,
        "START sets the displacement before any stop has one",
    ),
    "joint_nodes/controller.py:167:21 constant 1.0": (
        EQUIVALENT,
        "START sets the bias to 0 before any torque has one",
    ),
    "joint_nodes/controller.py:264:32 arithmetic self.speed * self._period / cycles": (
        GAP,
        "no check has an encoder leap in the cycle after a lost one",
    ),
    "joint_nodes/state_actions.py:66:68 constant False": (
        GAP,
        "no check takes a joint out of its range while it stops",
    ),
    "node/endpoint.py:92:11 branch False": (
        EQUIVALENT,
        "no bus hands a node an identifier that it does not accept",
    ),
    "joint_nodes/controller.py:171:28 constant 1": (
        EQUIVALENT,
        "the SYNCs of homing have set it to 0 before any cycle is counted",
    ),
    "joint_nodes/friction.py:132:93 constant (-1.0)": (
        EQUIVALENT,
        "RATE_PER_CODE is never 0, so neither is the speed that counts as moving",
    ),
    "joint_nodes/servo.py:406:41 swap min(state.transfer, step)": (
        EQUIVALENT,
        "the lesser of two is the same in any order",
    ),
    "joint_nodes/servo.py:201:34 swap _dot(rates, rows.inertia_row)": (
        EQUIVALENT,
        "a product of two vectors is the same in any order",
    ),
    "joint_nodes/ladder.py:54:36 constant 2": (
        EQUIVALENT,
        "what happens at once goes to the one step of its ladder, whatever its count",
    ),
    "joint_nodes/stop_ramp.py:38:28 constant (-1.0)": (
        EQUIVALENT,
        "each cycle steps the ramp before it asks its acceleration",
    ),
    "joint_nodes/field_node.py:140:29 constant True": (
        EQUIVALENT,
        "it is asked where the last SYNC said that the bus drives: then one has come",
    ),
}

MISSED: Final[dict[str, str]] = {}
