"""Checks 52j and 53c: frames that are bad again and again, and a second master."""

from collections.abc import Callable
from typing import Any, Final

from rfms_can.conform.checks.emergencies import emergency, noted
from rfms_can.conform.checks.ladder import bare, operational
from rfms_can.conform.checks.presence import WINDOW
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import MASTER, PLANT
from rfms_can.wire.records import Heartbeat, JointError, Measure, Nmt, Setpoint, Sync
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState

S, F, C = NodeState, FaultCode, Command

MOST_CYCLES: Final = 2**32
Spoil = Callable[[Frame], Frame]


def _crc(frame: Frame) -> Frame:
    return Frame(frame.id, bytes((frame.data[0] ^ 1, *frame.data[1:])))


def _shorter(frame: Frame) -> Frame:
    return Frame(frame.id, frame.data[:-1] if len(frame.data) <= 8 else frame.data[:8])


def _classic(frame: Frame) -> Frame:
    return Frame(frame.id, frame.data[:8], fd=False)


# --- frames that are bad --------------------------------------------------------------------------


def bad_frames(t: Tester) -> None:
    """Three of an identifier within ten cycles stop the joint; fewer, or of several, do not."""
    for at, stops in (((0, 4, 9), True), ((0, 0, 0), True), ((0, 5, 10), False), ((0, 9), False)):
        for spoil in (_crc, _shorter, _classic):
            _spoiled(t, at, spoil, stops=stops)
    for record, node, culprit in _senders(t):
        operational(t)
        for number in range(3):
            frame = _crc(_some(t, record, node))
            _expect(t, t.give(frame), frame.id, culprit, last=number == 2)
    # one of each identifier is none too many
    operational(t)
    for record, node, _ in _senders(t):
        t.give(*(_crc(_some(t, record, node)) for _ in range(2)))
    t.only(bare(t.run()), ("ERROR", "DAC"))
    noted(t, S.OPERATIONAL)
    _not_their_counter(t)
    _forgotten(t)


def _senders(t: Tester) -> list[tuple[type[Any], int | None, int]]:
    """Frames, and whose they are."""
    other = t.joint % 6 + 1
    return [
        (Measure, t.joint, PLANT),
        (Setpoint, 1, MASTER),
        (Nmt, None, MASTER),
        (Sync, None, MASTER),
        (Heartbeat, MASTER, MASTER),
        (JointError, other, other),
        (JointError, t.joint, t.joint),
    ]


def _some(t: Tester, record: type[Any], node: int | None) -> Frame:
    """A frame whose CRC will be spoiled; its counter is taken back."""
    frame = Frame(t.codec(record, node).id, bytes(t.codec(record, node).length))
    return frame


def _expect(t: Tester, answers: Answers, identifier: int, culprit: int, *, last: bool) -> None:
    t.only(answers, ("EMCY",) if last else (), f"a bad frame {identifier:#05x}")
    if last:
        told = dict(culprit=culprit, frame=identifier, value=3, bound=10)
        emergency(t, answers, F.BAD_FRAMES, **told)  # type: ignore[arg-type]
        noted(t, S.QUICKSTOP, F.BAD_FRAMES)


def _spoiled(t: Tester, at: tuple[int, ...], spoil: Spoil, *, stops: bool) -> None:
    """Bad MEASUREs in some cycles, beside a good one."""
    operational(t)
    identifier = t.codec(Measure, t.joint).id
    for cycle in range(at[-1] + 1):
        t.sync()
        for number in (n for n, when in enumerate(at) if when == cycle):
            bad = spoil(Frame(identifier, bytes(t.codec(Measure, t.joint).length)))
            last = stops and number == len(at) - 1
            _expect(t, t.give(bad), identifier, PLANT, last=last)
            if last:
                return
        t.only(t.measure() + t.setpoint() + t.errors(), ("ERROR", "DAC"), f"bad ones in {at}")
    noted(t, S.OPERATIONAL)


def _not_their_counter(t: Tester) -> None:
    """A frame that is refused for its counter is a good one."""
    operational(t)
    frame = t.frame(Nmt, None, C.ANNOUNCE, 31, 0)
    t.send(frame)
    for _ in range(4):
        t.only(t.give(frame), (), "the same frame again")
    noted(t, S.OPERATIONAL)


def _forgotten(t: Tester) -> None:
    """START, HOME and RESET forget, and no state but those that are driven counts."""
    identifier = t.codec(Measure, t.joint).id
    bad = _crc(Frame(identifier, bytes(t.codec(Measure, t.joint).length)))
    t.configure()
    t.give(bad, bad, bad, bad)
    noted(t, S.PREOP)
    t.command(C.HOME)
    t.sync(S.HOMING)
    t.give(bad, bad)
    t.measure()
    t.reference()
    noted(t, S.READY)
    t.give(bad, bad, bad)
    t.start()
    t.run(2)
    t.give(bad, bad)
    noted(t, S.OPERATIONAL)
    for leave in ((C.STOP,), (C.QUICKSTOP, C.RESET)):
        for command in leave:
            t.command(command)
        if leave[-1] is C.RESET:
            t.home(t.theta)
        t.start()
        t.run(1)
        t.give(bad, bad)
        noted(t, S.OPERATIONAL)
    t.configure()
    t.command(C.HOME)
    t.sync(S.HOMING)
    _expect_homing(t, t.give(bad, bad, bad))


def _expect_homing(t: Tester, answers: Answers) -> None:
    t.only(answers, ("EMCY",), "three bad frames while it homes")
    t.equal([e.fault for e in answers.of("EMCY")], [F.BAD_FRAMES], "faults")
    noted(t, S.PREOP, F.BAD_FRAMES)


# --- a second master ------------------------------------------------------------------------------


def foreign_master(t: Tester) -> None:
    """SYNCs whose cycles are more than four apart, either way; in no state that is not driven."""
    for ahead, foreign in ((1, False), (4, False), (-4, False), (0, False), (5, True), (-5, True)):
        _another_sync(t, ahead, foreign=foreign)
    _another_sync(t, 900, foreign=True, refused=True)
    _another_sync(t, 2, foreign=False, refused=True)
    if t.line.virtual:  # the tester holds the time
        for ahead, foreign in ((6, False), (7, True)):
            _after_missed(t, ahead, foreign=foreign)
    _wraps(t)
    _where_nothing_drives(t)


def _another_sync(t: Tester, ahead: int, *, foreign: bool, refused: bool = False) -> None:
    """A SYNC of another cycle, taken or refused for its counter."""
    operational(t)
    t.run(9)
    last = t.cycle
    if refused:
        t.skip_counter(Sync, None, WINDOW)
    answers = bare(t.say(Sync, None, last + ahead, S.OPERATIONAL, 0, t.wire.dbc_hash))
    why = f"SYNC {ahead} after the last one"
    if not foreign:
        t.only(answers, (), why)
        noted(t, S.OPERATIONAL)
        return
    _told(t, answers, last + ahead, last, why)
    if refused:
        t.skip_counter(Sync, None, -WINDOW - 1)
    # it has no other effect: the cycle under way goes on, and the next SYNC is the next
    t.one(t.measure(), "DAC", "the stop, in the cycle under way")
    t.only(bare(t.sync(S.QUICKSTOP)), (), "the first master's next SYNC")
    noted(t, S.QUICKSTOP, F.FOREIGN_MASTER)


def _after_missed(t: Tester, ahead: int, *, foreign: bool) -> None:
    """Two SYNCs are missed: the master's own may be two numbers farther."""
    operational(t)
    t.run(3)
    last = t.cycle
    t.only(t.elapse(2.6 * t.period_ns * 1e-9), (), "two SYNCs missed")
    answers = bare(t.say(Sync, None, last + ahead, S.OPERATIONAL, 0, t.wire.dbc_hash))
    t.only(answers, ("EMCY",) if foreign else (), f"SYNC {ahead} after the last, two missed")
    noted(
        t, S.QUICKSTOP if foreign else S.OPERATIONAL, F.SYNC_MISSING, *[F.FOREIGN_MASTER] * foreign
    )


def _told(t: Tester, answers: Answers, cycle: int, last: int, why: str) -> None:
    t.only(answers, ("EMCY",), why)
    told = dict(culprit=MASTER, frame=t.codec(Sync).id, value=cycle, bound=last, tolerance=1e-6)
    emergency(t, answers, F.FOREIGN_MASTER, **told)  # type: ignore[arg-type]
    noted(t, S.QUICKSTOP, F.FOREIGN_MASTER)


def _wraps(t: Tester) -> None:
    """Cycles are counted modulo 2^32; the first SYNC after HOME or START may have any number."""
    t.configure()
    t.theta = 0.1
    t.command(C.HOME)
    t.cycle = MOST_CYCLES - 3
    t.sync(S.HOMING)
    t.measure()
    for cycle in (MOST_CYCLES - 1, 1):
        t.say(Sync, None, cycle, S.HOMING, 0, t.wire.dbc_hash)
        noted(t, S.HOMING)
    answers = bare(t.say(Sync, None, MOST_CYCLES - 4, S.HOMING, 0, t.wire.dbc_hash))
    t.only(answers, ("EMCY",), "SYNC five before the last one, over the end of its numbers")
    t.equal([e.fault for e in answers.of("EMCY")], [F.FOREIGN_MASTER], "faults")
    noted(t, S.PREOP, F.FOREIGN_MASTER)


def _where_nothing_drives(t: Tester) -> None:
    """READY, PREOP, and FAULT without torque: any SYNC will do."""
    t.ready()
    for cycle in (900, 77, 100_000):
        t.cycle = cycle
        t.sync(S.READY)
    noted(t, S.READY)
    t.start()
    t.cycle = 70
    t.sync()
    noted(t, S.OPERATIONAL)
    t.estop()
    t.cycle = 7
    t.sync()
    noted(t, S.FAULT, F.EMERGENCY_STOP)
    t.configure()
    t.cycle = 900
    t.sync(S.PREOP)
    noted(t, S.PREOP)
