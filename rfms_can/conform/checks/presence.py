"""Checks 1 to 4 and 50: the node is there, and says so when it is asked."""

from rfms_can.conform.outcome import CheckSkipped
from rfms_can.conform.samples import UNKNOWN_PARAMETER
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import QUIET_S, Tester
from rfms_can.wire.nodes import HEARTBEAT_EVERY, MASTER
from rfms_can.wire.records import Config, Heartbeat, Nmt, Sync
from rfms_can.wire.vocabulary import Command, NodeState

WINDOW = 16
"""Largest step of a counter that is taken (RfmsCounterWindow)."""
ROW = 3
"""Frames out of step in a row of which the last is taken (RfmsCounterRestart)."""


def power_on(t: Tester) -> None:
    """One HEARTBEAT, and nothing else."""
    answers = t.power_on()
    if answers is None:
        answers = t.boot
    if answers is None:
        raise CheckSkipped("the node was on before: --power-on sees it start")
    beat = t.one(answers, "HEARTBEAT", "at power-on")
    t.equal(answers[0].counter, 0, "counter of the first HEARTBEAT")
    t.equal(NodeState(beat.state).name, "PREOP", "state")
    told = (beat.config_hash, beat.error_register, beat.discarded, beat.bus_offs, beat.overflows)
    t.equal(told, (0, 0, 0, 0, 0), "configuration hash, faults, discarded, bus-offs, overflows")
    t.only(t.elapse(QUIET_S), (), "nothing more until it is spoken to")
    t.greet()


def announce(t: Tester) -> None:
    """Asked all together or alone, the node answers."""
    t.to_preop()
    for node in (0, t.joint):
        for argument in (0, 0xFFFF):
            answers = asked(t, node, argument)
            beat = t.one(answers, "HEARTBEAT", f"ANNOUNCE to {node}")
            t.equal(NodeState(beat.state).name, "PREOP", "state")


def announce_others(t: Tester) -> None:
    """Asked another node, it is quiet."""
    t.to_preop()
    for node in range(1, 32):
        if node != t.joint:
            t.only(t.command(Command.ANNOUNCE, node), (), f"ANNOUNCE to {node}")
            for command in (Command.HOME, Command.START, Command.RESET, Command.QUICKSTOP):
                t.only(t.command(command, node), (), f"{command.name} to {node}")
    t.only(t.elapse(QUIET_S), ())
    t.state_is(NodeState.PREOP)


def asked(t: Tester, node: int = 0, argument: int = 0) -> Answers:
    """NMT ANNOUNCE."""
    return t.command(Command.ANNOUNCE, node, argument)


class _Counters:
    """CONFIG with counters of choice, of which each that is taken is answered."""

    def __init__(self, t: Tester) -> None:
        self._t = t
        self._before = t.beat().discarded
        self._refused = 0

    def step(self, steps: int, taken: bool, why: str) -> None:
        """A frame so many ahead of the one taken last."""
        t = self._t
        t.skip_counter(Config, t.joint, steps - 1)
        t.send(t.frame(Config, t.joint, UNKNOWN_PARAMETER, 0, 1.0, 0))
        discarded = t.beat().discarded - self._before  # no other CONFIG may come in between
        t.only(t.came(), ("CONFIG_ACK",) if taken else (), why)
        if not taken:
            self._refused += 1
            t.skip_counter(Config, t.joint, -steps)
        t.equal(discarded, self._refused, f"discarded frames after {why}")

    def to_255(self) -> None:
        """Frames in step up to the last number of a counter."""
        while left := 255 - self._t.counter(Config, self._t.joint) & 0xFF:
            self.step(min(left, WINDOW), True, "a frame in step")
        self.step(1, True, "counter 255")

    def strays(self, first: int, count: int, apart: int = 1) -> None:
        """Frames out of step in a row, the last of which is taken."""
        for number in range(1, count + 1):
            why = f"frame {number} out of step of {count}"
            self.step(first + (number - 1) * apart, number == count, why)


def counter_rule(t: Tester) -> None:
    """The one rule, on CONFIG."""
    t.to_preop()
    counters = _Counters(t)
    step, strays = counters.step, counters.strays
    t.send(t.frame(Nmt, None, Command.RESET, 0, 0))
    step(120, True, "the first frame after RESET, whatever its counter")
    step(0, False, "the same frame again")
    step(150, True, "the second frame, its counter another")
    step(0, False, "the counter of the frame before")
    step(-1, False, "a counter 1 back")
    step(WINDOW + 1, False, "a counter 17 ahead")
    step(128, False, "a counter 128 ahead")
    step(1, True, "a counter 1 ahead")
    step(WINDOW, True, "a counter 16 ahead")
    step(2, True, "a counter 2 ahead")
    # two strays, one in step, and two strays again: never three in a row
    step(100, False, "a first stray")
    step(101, False, "a second stray")
    step(1, True, "a frame in step between them")
    step(101, False, "a first stray again")
    step(102, False, "a second stray again")
    step(1, True, "a frame in step")
    # strays too far from one another begin a new row
    step(60, False, "a stray")
    step(60 + WINDOW + 1, False, "a stray 17 on from the stray before")
    step(60 + 2 * WINDOW + 2, False, "a stray 17 on again")
    step(1, True, "a frame in step")
    # nor is one that comes again in step with itself
    for number in range(1, 5):
        step(70, False, f"the same stray, time {number}")
    step(1, True, "a frame in step")
    strays(100, ROW, WINDOW)
    step(1, True, "the frame after the leap")
    strays(90, 2 * ROW)
    strays(90, 4 * ROW)
    counters.to_255()
    step(WINDOW + 1, False, "a counter 17 ahead of 255")
    step(1, True, "counter 0 after 255")
    for counter in range(1, 257):
        step(WINDOW + 1, False, f"a counter 17 ahead of {counter - 1}")
        step(1, True, f"counter {counter & 0xFF}")
    t.send(t.master_beat(t.boot_id ^ 0x55))
    step(77, True, "the first frame after a HEARTBEAT of the master with another boot id")
    step(1, True, "the next")
    step(1, True, "the next")
    strays(90, ROW)
    t.send(t.master_beat(t.boot_id ^ 0x55))
    step(-20, False, "a counter back, after a HEARTBEAT with the same boot id")
    t.skip_counter(Heartbeat, MASTER, -1)  # it counts from anywhere, as any that has started
    t.send(t.master_beat())
    step(1, True, "the first frame after a HEARTBEAT with another boot id")


def counter_rule_of_nmt(t: Tester) -> None:
    """NMT is no exception."""
    t.to_preop()
    t.only(asked(t), ("HEARTBEAT",))
    t.only(asked(t), ("HEARTBEAT",))
    before = t.beat().discarded
    for steps, taken in (
        (0, False),
        (-1, False),
        (-20, False),
        (WINDOW + 1, False),
        (WINDOW, True),
    ):
        t.skip_counter(Nmt, None, steps - 1)
        t.only(asked(t), ("HEARTBEAT",) if taken else (), f"NMT with a counter {steps} ahead")
        if not taken:
            t.skip_counter(Nmt, None, -steps)
    t.equal(t.beat().discarded - before, 4, "discarded frames")


def heartbeat_phase(t: Tester) -> None:
    """With each SYNC whose number is a multiple of 12, and with no other."""
    t.configure()
    for cycle in (*range(26), 47, 48, 49, 0xFFFFFFFC, 0xFFFFFFFD, 12):
        t.cycle = cycle - 1
        answers = t.sync(NodeState.PREOP)
        due = cycle % HEARTBEAT_EVERY == 0
        t.only(answers, ("HEARTBEAT",) if due else (), f"SYNC {cycle}")
    t.to_preop()
    t.say(Sync, None, 0, NodeState.PREOP, 0, t.wire.dbc_hash)
