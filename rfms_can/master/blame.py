"""Who is to blame where a node tells of a frame that it misses: its sender, or the node itself.

A node that does not hear tells the same as one that is not spoken to. The master knows more: what
it has heard itself was sent, and a SYNC or a set-point that others have answered has gone out.
"""

from collections.abc import Callable, Mapping
from typing import Final

from rfms_can.master.fault import Fault
from rfms_can.master.inputs import CycleInputs
from rfms_can.messages.culprit import Culprit
from rfms_can.wire.contract import Wire
from rfms_can.wire.emergency import in_words
from rfms_can.wire.nodes import JOINTS, NODE_NAMES
from rfms_can.wire.records import Emcy
from rfms_can.wire.vocabulary import FaultCode

Evidence = Callable[[CycleInputs, int, Emcy], str]
"""What speaks against a node that misses a frame: that it was on the bus; or ``""``."""


def _others(bits: int, node: int) -> int:
    return bits & ~(1 << node - 1) if node in JOINTS else bits


def _sync(inputs: CycleInputs, node: int, _: Emcy) -> str:
    others = _others(inputs.spoken | inputs.spoken_before, node)
    return "other nodes have answered it" if others else ""


def _setpoint(inputs: CycleInputs, node: int, _: Emcy) -> str:
    others = _others(inputs.told | inputs.told_before, node)
    return "other joints have answered it" if others else ""


def _measure(inputs: CycleInputs, node: int, _: Emcy) -> str:
    sampled = inputs.sampled | inputs.sampled_before
    return "the master has heard it" if node in JOINTS and sampled >> node - 1 & 1 else ""


def _error(inputs: CycleInputs, _: int, emergency: Emcy) -> str:
    told, missed = inputs.told | inputs.told_before, emergency.culprit
    return "the master has heard it" if missed in JOINTS and told >> missed - 1 & 1 else ""


_EVIDENCE: Final[Mapping[int, Evidence]] = {
    FaultCode.SYNC_MISSING: _sync,
    FaultCode.SETPOINT_MISSING: _setpoint,
    FaultCode.MEASURE_MISSING: _measure,
    FaultCode.ERROR_MISSING: _error,
}
"""Of faults that are about a frame which many hear; ROWS of a joint is heard by it alone."""
_OF_ITS_BOARD: Final = frozenset((FaultCode.ENCODER_GLITCH, FaultCode.HOMING_FAILED))
"""Faults that are about what a sample says: of the joint's encoder, whoever sends the sample."""


def blame(wire: Wire, inputs: CycleInputs, node: int, emergency: Emcy, cycle: int) -> Fault:
    """What an EMCY halts the arm for.

    Args:
        wire: compiled codecs.
        inputs: what the cycle under way, and the one before, have brought.
        node: who has sent it.
        emergency: what it tells.
        cycle: the one under way.
    """
    words = f"{NODE_NAMES[node]}: {in_words(wire, node, emergency)}"
    culprit = NODE_NAMES.get(emergency.culprit, NODE_NAMES[node])
    evidence = _EVIDENCE.get(emergency.fault)
    against = evidence(inputs, node, emergency) if evidence and emergency.culprit != node else ""
    if emergency.fault in _OF_ITS_BOARD:
        culprit = NODE_NAMES[node]
    if against:
        words = f"{words}; but {against}: {NODE_NAMES[node]} does not hear"
        culprit = NODE_NAMES[node]
    frame = next((c.name for c in wire.codecs.values() if c.id == emergency.frame), "")
    return Fault(
        words,
        Culprit(
            culprit,
            frame if emergency.frame else "",
            cycle,
            emergency.value,
            emergency.bound or None,
        ),
    )
