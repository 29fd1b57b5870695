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
        "joint_nodes/stop_ramp.py StopPlan.ramp swap (min(position - theta, far)) #f5bb7076",
        "plant/board.py Board.set_dacs swap (min(FORCE_DAC_FINENESS * HIGHEST_CODE,  #91ddad04",
    ),
    "the larger of two is the same in any order": (
        "plant/board.py Board.set_dacs swap (max(LOWEST_CODE, current_code)) #ecc53e5b",
    ),
    "a shortcut: what it does not let pass is judged whole, and found well": (
        "master/verification.py Verification.check comparison (-AGREEMENT <= off - error > "
        "AGREEMENT) #db1f3625",
        "master/verification.py Verification.check boundary (-bound <= real < bound) #81df00ef",
    ),
    "the long way to the same: a frame that follows directly is one step ahead": (
        "wire/protection.py Receiver.take branch (False) #7e35ed8c",
        "wire/protection.py Receiver._is_taken_up constant (1) #4ac51e87",
    ),
    "no counter is any of these numbers": (
        "wire/protection.py Receiver.reset constant (2) #ac3d413f",
    ),
    "asked only where the controller drives": (
        "joint_nodes/joint.py JointNode._drop branch (True) #d881287b",
    ),
    "not read before five DACs have taken its place": (
        "joint_nodes/detectors/drive.py AmplifierWatch.__init__ constant (1.0) #47760f19",
    ),
    "each SYNC sets it before it is asked": (
        "master/lateness.py Lateness.forget constant (1) #f89a6143",
    ),
    "a difference without its sign": (
        "master/verification.py Verification._straying swap (zip(measured, goals, strict=True)) "
        "#b85c76d8",
    ),
    "the same float32": ("joint_nodes/field_node.py module constant (1000000001.0) #3dbcf0b0",),
    "the next line gives SYNC another handler": (
        "joint_nodes/field_node.py FieldNode.__init__ swap (self._hears(Sync, self._on_sync, "
        "None)) #64206644",
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
    "the first step of homing does so too": (
        "joint_nodes/controller.py JointController._begin_homing deletion pass #e0d6ed34",
    ),
}
"""Equivalents: what they have in common, and their names."""

GAPS: Final[dict[str, tuple[str, ...]]] = {
    "which way the error of a simulated potentiometer goes is the plant's choice": (
        "plant/board.py Board.coarse arithmetic (q - error) #fdf03c4a",
    ),
    "no test brings a stray again when as many frames have come since as there are counters": (
        "wire/protection.py Receiver._ends_a_row constant (1) #fd2c570a",
    ),
    "no test asks who is to blame for the end of the range after a stop and another START": (
        "joint_nodes/controller.py JointController._commanded negation ((ramp is not None or "
        "self.action.torque #0905943f",
    ),
    "no test steps SYNC by half of all its numbers, to a joint that is not driven": (
        "joint_nodes/controller.py JointController._gap boundary (ahead <= LAST_CYCLE // 2) "
        "#c3fa080a",
    ),
    "a default that the master alone uses: its own tests ask, those of a node do not": (
        "node/endpoint.py Endpoint._beat constant ((-1)) #cb6e4297",
    ),
}
"""Survivors that do something else, and that no test of the file asks: why."""

SURVIVED_FOR: Final[dict[str, tuple[str, str]]] = {
    name: (word, why)
    for word, families in ((EQUIVALENT, SAME_FOR), (GAP, GAPS))
    for why, names in families.items()
    for name in names
}
