"""Why no test kills a mutant of the safety core: by names, which stay when lines move."""

from typing import Final

from node_mutants.survivors import EQUIVALENT, GAP

SAME_FOR: Final[dict[str, tuple[str, ...]]] = {
    "None is as false as False": (
        "joint_nodes/inputs.py CycleInputs.setpoint_complete return (None) #0ee762f0",
    ),
    "the lesser of two is the same in any order": (
        "master/verification.py following_bounds swap (min(max(LEAST * softness, bound), most) "
        "#9a7d67da",
        "node/endpoint.py Endpoint._beat swap (min(_MAX_U16, self.discarded)) #49d2a27a",
    ),
    "the larger of two is the same in any order": (
        "plant/board.py Board.set_dacs swap (max(LOWEST_CODE, current_code)) #ecc53e5b",
    ),
    "a shortcut: what it does not let pass is judged whole, and found well": (
        "master/verification.py Verification.check comparison (-AGREEMENT <= off - error > "
        "AGREEMENT) #db1f3625",
    ),
    "a step does only what the frames so far allow, however often it is asked": (
        "joint_nodes/joint.py JointNode._on_error negation ((inputs.heard == ALL_ERRORS or "
        "self.con #0fd9f6e2",
    ),
    "an error of 0 is within the bound: left before": (
        "joint_nodes/detectors/runaway.py RunawayWatch.watch boundary (error >= 0.0) #8b2e3c75",
    ),
    "START sets it before it is asked": (
        "joint_nodes/controller.py JointController.__init__ constant (1.0) #43e0a340",
    ),
    "what is held while no set-point drives the joint is forgotten at START": (
        "joint_nodes/controller.py JointController.begin_cycle negation ((gap > 1 or node.state "
        "is NodeState.OPE #ff9c5d30",
    ),
    "INIT and PREOP in SYNC are the same to every action": (
        "joint_nodes/field_node.py FieldNode.__init__ member (NodeState.PREOP) #23df7604",
    ),
    "terms are recorded for tools alone": (
        "joint_nodes/joint.py JointNode._make_controller deletion pass #eaf2b0d7",
    ),
    "in PREOP nothing that is missed counts, and the next SYNC begins another cycle": (
        "joint_nodes/controller.py JointController._forget_cycle constant (True) #ac9ac01b",
    ),
    "COMMIT sets it with the hash, and nothing asks it without one": (
        "joint_nodes/field_node.py FieldNode.__init__ constant ((-1)) #17445940",
    ),
    "every message that is read from a DBC has what the DBC says of it": (
        "wire/codec.py layout_lines branch (True) #e860b6ea",
    ),
    "set by the first frame, before any takes it up": (
        "wire/protection.py Decoder.__init__ member (Refusal.CRC) #4abaf65c",
    ),
    "each sample sets them, and homing the angle, before they are asked": (
        "joint_nodes/controller.py JointController.__init__ constant (1.0) #4e564573",
    ),
}
"""Equivalents: what they have in common, and their names."""

GAPS: Final[dict[str, tuple[str, ...]]] = {
    "a default that the master alone uses: its own tests ask, those of a node do not": (
        "node/endpoint.py Endpoint._beat constant ((-1)) #cb6e4297",
    ),
    "no test begins a stop in motion at the last count of the range": (
        "joint_nodes/controller.py JointController.__init__ constant (2.0) #071654c8",
        "joint_nodes/controller.py JointController.__init__ constant (0.0) #cb62da4a",
    ),
}
"""Survivors that do something else, and that no test of the file asks: why."""

SURVIVED_FOR: Final[dict[str, tuple[str, str]]] = {
    name: (word, why)
    for word, families in ((EQUIVALENT, SAME_FOR), (GAP, GAPS))
    for why, names in families.items()
    for name in names
}
