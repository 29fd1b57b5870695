"""An emergency message in words: what went wrong, by how much, and who is to blame."""

from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import NODE_NAMES
from rfms_can.wire.records import Emcy
from rfms_can.wire.vocabulary import FaultCode, name_of


def in_words(wire: Wire, node: int, emergency: Emcy) -> str:
    """The message of a node, e.g. ``MEASURE_MISSING (3, bound 3): MEASURE_3 of plant``."""
    fault = name_of(FaultCode, emergency.fault)
    bound = f", bound {emergency.bound:g}" if emergency.bound else ""
    words = f"{fault} ({emergency.value:g}{bound})"
    culprit = NODE_NAMES.get(emergency.culprit)
    frames = [codec.name for codec in wire.codecs.values() if codec.id == emergency.frame]
    about = frames[0] if frames and emergency.frame else ""
    if culprit is None or emergency.culprit == node:
        return f"{words}: {about}" if about else words
    return f"{words}: {about} of {culprit}" if about else f"{words}: {culprit}"
