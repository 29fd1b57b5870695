"""Why the suite does not kill a mutant, and why the master does not stop one: by their names."""

from typing import Final

from node_mutants.equivalents import SAME_FOR

EQUIVALENT: Final = "equivalent"
"""On the bus it does what the code as it is does: to the frame, or to less than a count."""
GAP: Final = "gap"
"""It does not, and no check asks."""

SURVIVED_FOR: Final[dict[str, tuple[str, str]]] = {
    **{name: (EQUIVALENT, why) for why, names in SAME_FOR.items() for name in names},
    "joint_nodes/angle_solver.py:71:28 boundary self._lower <= angle < self._upper": (
        EQUIVALENT,
        "no pose of float32 solves to the end of a range to the bit",
    ),
    "joint_nodes/controller.py:150:23 constant 0": (
        EQUIVALENT,
        "before START it counts for the samples alone, which none compares then; START sets it",
    ),
    "joint_nodes/controller.py:150:23 constant 2": (
        EQUIVALENT,
        "before START it counts for the samples alone, which none compares then; START sets it",
    ),
    "joint_nodes/controller.py:410:8 deletion pass": (
        EQUIVALENT,
        "the first cycle of homing resets the servo again, and none uses it before",
    ),
    "joint_nodes/controller.py:447:12 arithmetic ramp.position -= jump": (
        GAP,
        "no check lets the encoder jump for good while the joint stops",
    ),
    "joint_nodes/detectors/drive.py:66:22 boundary current_adc <= low": (
        EQUIVALENT,
        "no code is the border to the bit: the tolerance is no whole number",
    ),
    "joint_nodes/field_node.py:146:21 sign (1)": (
        GAP,
        "no check asks the cycle of an EMCY before any SYNC",
    ),
    "joint_nodes/field_node.py:146:8 deletion pass": (
        GAP,
        "no check asks the cycle of an EMCY before any SYNC",
    ),
    "joint_nodes/field_node.py:163:23 constant True": (
        EQUIVALENT,
        "the first HEARTBEAT_8 is the master's in any case",
    ),
    "joint_nodes/field_node.py:165:25 constant 1": (
        EQUIVALENT,
        "COMMIT sets it before the watchdog runs",
    ),
    "joint_nodes/field_node.py:327:8 deletion pass": (
        EQUIVALENT,
        "no tester on the bus has the node's controller in its hand",
    ),
    "joint_nodes/field_node.py:374:12 deletion pass": (
        EQUIVALENT,
        "what is ignored is counted for people at the node, not on the bus",
    ),
    "joint_nodes/field_node.py:481:53 constant 999999999.0": (
        EQUIVALENT,
        "a watchdog of periods that is a billionth off runs off in the same cycle",
    ),
    "joint_nodes/friction.py:132:77 constant (-1.0)": (
        EQUIVALENT,
        "RATE_PER_CODE is never 0, so neither is the speed that counts as moving",
    ),
    "joint_nodes/inputs.py:59:23 constant (-1.0)": (
        EQUIVALENT,
        "the errors of a cycle are all set before they are used",
    ),
    "joint_nodes/inputs.py:92:19 return None": (
        EQUIVALENT,
        "None is as false as False",
    ),
    "joint_nodes/joint.py:115:41 constant 2": (
        EQUIVALENT,
        "what is ignored is counted for people at the node, not on the bus",
    ),
    "joint_nodes/ladder.py:37:13 constant 2": (
        EQUIVALENT,
        "HOLD sends nothing: it is the cycle without a set-point that is held",
    ),
    "joint_nodes/ladder.py:46:36 constant 0": (
        EQUIVALENT,
        "HOLD sends nothing, and a count is never 0 where it is asked",
    ),
    "joint_nodes/ladder.py:49:35 constant 2": (
        EQUIVALENT,
        "what happens at once goes to the one step of its ladder, whatever its count",
    ),
    "joint_nodes/ladder.py:51:36 constant 0": (
        EQUIVALENT,
        "what happens at once goes to the one step of its ladder, whatever its count",
    ),
    "joint_nodes/sensing.py:194:11 boundary -self._overspeed <= speed < self._overspeed": (
        EQUIVALENT,
        "no code's speed is the limit to the bit: both have travelled as float32",
    ),
    "joint_nodes/servo.py:190:7 branch True": (
        EQUIVALENT,
        "without damping the product is 0",
    ),
    "joint_nodes/stop_ramp.py:109:11 boundary rate * measured >= 0.0": (
        EQUIVALENT,
        "the lesser of two speeds, of which one is 0, is 0",
    ),
    "joint_nodes/stop_ramp.py:113:29 boundary speed >= 0.0": (
        EQUIVALENT,
        "a stop at rest has the deceleration of any, whichever end it could go to",
    ),
    "joint_nodes/servo.py:308:75 constant (-1.0)": (
        EQUIVALENT,
        "the friction is always given",
    ),
    "node/endpoint.py:167:12 swap self._heartbeat.frame(state, 0, register, self.boot_id, "
    "config_hash, self.wire.dbc_hash, min(self.discarded, _MAX_U16), 0)": (
        EQUIVALENT,
        "a joint tells its port's counts as well, with a HEARTBEAT of its own",
    ),
    "node/endpoint.py:19:18 constant 131070": (
        EQUIVALENT,
        "a joint tells its port's counts as well, with a HEARTBEAT of its own",
    ),
    "node/endpoint.py:46:8 deletion pass": (
        EQUIVALENT,
        "it is set whenever a frame or the time comes, before it is asked",
    ),
    "node/endpoint.py:93:12 arithmetic self.foreign -= 1": (
        EQUIVALENT,
        "what no one asked for is counted for people at the node, not on the bus",
    ),
    "wire/configuration.py:106:62 constant 2000000000.0": (
        EQUIVALENT,
        "CONFIG itself carries no larger value",
    ),
    "wire/configuration.py:135:76 constant 0.0": (
        GAP,
        "no check leaves the tolerance of the current at its default",
    ),
}

MISSED: Final[dict[str, str]] = {}
