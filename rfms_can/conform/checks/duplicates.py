"""Check 53b: a second node sends as this one does."""

from typing import NamedTuple

from rfms_can.conform.checks.emergencies import emergency, noted
from rfms_can.conform.checks.safety import brought_to
from rfms_can.conform.tester import Tester
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import ConfigAck, Dac, Emcy, Heartbeat, JointError
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState

S, F, C = NodeState, FaultCode, Command


def duplicate(t: Tester) -> None:
    """A frame under each identifier of its own, in each state: a stop, told once."""
    n, hash_ = t.joint, t.wire.dbc_hash
    own: tuple[tuple[type[NamedTuple], tuple[float, ...]], ...] = (
        (Heartbeat, (S.PREOP, 0, 0, 0xBEEF, hash_, 0, 0, 0)),
        (Emcy, (F.SOFT_LIMIT, n, 0, 0.0, 0.0, 0, 0)),
        (ConfigAck, (200, 1, 0.0, 0)),
        (JointError, (0.0, 0.0, 0.0, 0)),
        (Dac, (0, 0, 0)),
    )
    ends = {S.PREOP: S.PREOP, S.HOMING: S.PREOP, S.READY: S.PREOP}
    for record, values in own:
        for state in (S.PREOP, S.HOMING, S.READY, S.OPERATIONAL, S.QUICKSTOP):
            brought_to(t, state)
            answers = t.say(record, n, *values)
            t.only(answers, ("EMCY",), f"{record.__name__} of its own number in {state.name}")
            told = dict(culprit=n, frame=t.codec(record, n).id, value=1.0, bound=0.0)
            emergency(t, answers, F.DUPLICATE_NODE, **told)  # type: ignore[arg-type]
            noted(t, ends.get(state, S.QUICKSTOP), F.DUPLICATE_NODE)
            t.only(t.say(record, n, *values), (), "once more")
            for command in (C.HOME, C.START):
                t.only(t.command(command), (), f"{command.name} before RESET")
            noted(t, ends.get(state, S.QUICKSTOP), F.DUPLICATE_NODE)
        t.command(C.RESET)
        noted(t, S.PREOP)
    # a wrong frame proves nothing, and off is harder than a stop
    t.configure()
    frame = t.frame(Dac, n, 0, 0, 0)
    before = t.beat().discarded
    wrong = Frame(frame.id, bytes([frame.data[0] ^ 1, *frame.data[1:]]))
    t.only(t.give(wrong), (), "a wrong CRC")
    t.equal(t.beat().discarded - before, 1, "discarded frames")
    noted(t, S.PREOP)
    brought_to(t, S.OPERATIONAL)
    t.estop()
    t.only(t.say(Dac, n, 0, 0, 0), (), "in FAULT")
    noted(t, S.FAULT, F.EMERGENCY_STOP, F.DUPLICATE_NODE)
