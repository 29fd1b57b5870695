"""What a stranger on the bus makes of what it hears: reactions, motion, brakes, what comes back."""

import errno
import os
import signal
import socket
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest

from rfms_can.arm import arm_by_name
from rfms_can.bus.hub.port import HubPort
from rfms_can.faults.facts import Facts
from rfms_can.faults.processes.effect import Scene, effect_ns
from rfms_can.faults.processes.evidence import SETTLED, Evidence, reaction_told
from rfms_can.faults.processes.injectors import Shows
from rfms_can.faults.processes.joints import Joints
from rfms_can.faults.processes.seams import sends_fail, wall_clock_jumps
from rfms_can.faults.processes.tape import Heard
from rfms_can.faults.table import JOINT, Expected, Variant, Where
from rfms_can.joint_nodes.ladder import LADDERS, Reaction
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.nodes import JOINTS, MASTER, PLANT
from rfms_can.wire.records import Dac, Emcy, Estop, Heartbeat, Measure, Nmt, Sync
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState

ARM = arm_by_name("puma260")
CYCLE_NS = 100_000_000
COUNTS = [
    round(abs(d.counts_per_radian) * v * 0.004)
    for d, v in zip(ARM.drives, ARM.speed_limits, strict=True)
]
"""Encoder counts in a period at each joint's speed limit."""
MS = 1_000_000


def variant(expected: Expected = Expected.R2, culprit: str = JOINT) -> Variant:
    return Variant("", 3, expected, culprit, where=Where.PROCESSES)


def emcy(fault: FaultCode, bound: float, culprit: int = MASTER) -> Emcy:
    return Emcy(fault, culprit, 0, bound, bound, 0, 1)


class Bus:
    """Frames that a stranger hears, one after another."""

    def __init__(self, what: Variant, node: int = 3, back_ns: int | None = None) -> None:
        self.evidence = Evidence(Wire(), ARM, Joints(ARM, 0.004), what, node, 0, CYCLE_NS, back_ns)
        self.cycle = 0
        self.counts = [0] * len(JOINTS)

    def hear(self, at_ns: int, node: int, values: object) -> None:
        self.evidence.take(Heard(at_ns, node, values))

    def facts(self, **others: object) -> Facts:
        return self.evidence.facts(injected=1, **others)

    def measure(self, at_ns: int, speed: float, closed: tuple[int, ...] = ()) -> None:
        """A period in which all joints run at a part of their limits."""
        self.cycle += 1
        for joint in JOINTS:
            self.counts[joint - 1] += round(speed * COUNTS[joint - 1])
            values = Measure(
                self.counts[joint - 1], 0, 0, self.cycle & 0xFF, 1, int(joint in closed)
            )
            self.hear(at_ns, joint, values)


@pytest.mark.parametrize("fault", LADDERS)
def test_an_emergency_tells_how_hard_its_node_reacts(fault: FaultCode) -> None:
    for cycles, reaction in LADDERS[fault]:
        if reaction >= Reaction.STOP:
            assert reaction_told(emcy(fault, cycles)) is reaction


def test_a_fault_of_a_later_version_is_a_stop() -> None:
    assert reaction_told(Emcy(39, 1, 0, 0.0, 0.0, 0, 1)) is Reaction.STOP


def test_a_stop_is_found_named_and_measured() -> None:
    bus = Bus(variant(), node=3)
    for period in range(4):
        bus.measure(period * MS, 0.5)
    bus.hear(240 * MS, 0, Nmt(Command.QUICKSTOP, 0, 0))
    bus.measure(250 * MS, 0.3, closed=(3,))
    for period in range(6):
        bus.measure((260 + period) * MS, 0.0, closed=(3,))
    facts = bus.facts(named="joint 3", told="joint 3: no ERROR_3 for 3 cycles")
    assert (facts.stopped, facts.reached, facts.named) == (2.4, 2.4, "joint 3")
    assert facts.reactions == [2, 2, 4, 2, 2, 2]
    assert (facts.others, facts.brakes, facts.reenabled) == (2, [], [])
    assert facts.speed == pytest.approx(0.5, abs=0.02)
    assert facts.rest == pytest.approx(2.63, abs=0.02)


def test_the_first_emergency_names_whom_nodes_blame_unless_the_master_was_first() -> None:
    bus = Bus(variant(culprit="master"), node=MASTER)
    bus.hear(MS, 1, emcy(FaultCode.SYNC_MISSING, 3))
    bus.hear(2 * MS, 2, emcy(FaultCode.MEASURE_MISSING, 3, PLANT))
    facts = bus.facts(named="joint 1", told="else")
    assert (facts.named, facts.told[:8]) == ("master", "joint 1:")
    bus = Bus(variant())
    bus.hear(MS, 0, Sync(1, NodeState.QUICKSTOP, 0, 0))
    bus.hear(2 * MS, 2, emcy(FaultCode.SYNC_MISSING, 3))
    assert bus.facts(named="joint 3", told="x").named == "joint 3"


@pytest.mark.parametrize(("wanted", "at_ms"), [(Expected.R2, 300), (Expected.R3, 500)])
def test_the_rung_that_is_wanted_counts(wanted: Expected, at_ms: int) -> None:
    bus = Bus(variant(wanted, "master"), node=MASTER)
    bus.hear(300 * MS, 1, emcy(FaultCode.SYNC_MISSING, 3))
    bus.hear(500 * MS, 1, emcy(FaultCode.SYNC_MISSING, 5))
    facts = bus.facts()
    assert (facts.stopped, facts.reached) == (3.0, at_ms / 100)
    assert facts.others == 0, "five have not said anything"


def test_an_emergency_stop_takes_the_torque_off_everywhere() -> None:
    bus = Bus(variant(Expected.R4, "master"), node=MASTER)
    bus.hear(MS, 0, Estop(*ESTOP_VALUES))
    assert bus.facts().reactions == [4] * 6


def test_a_brake_of_a_sound_joint_that_closes_in_motion_is_seen() -> None:
    bus = Bus(variant(), node=3)
    for period in range(3):
        bus.measure(period * MS, 0.4)
    bus.measure(4 * MS, 0.4, closed=(3, 5))
    assert bus.facts().brakes == [5]


def test_what_is_enabled_again_is_told() -> None:
    bus = Bus(variant(), node=3)
    bus.hear(MS, 0, Nmt(Command.QUICKSTOP, 0, 0))
    bus.measure(2 * MS, 0.0, closed=(3,))
    bus.measure(3 * MS, 0.0, closed=(3,))
    late = round((SETTLED + 0.1) * CYCLE_NS) + 3 * MS
    operational = Heartbeat(NodeState.OPERATIONAL, 0, 0, 1, 0, 0, 0, 0)
    for at_ns in (4 * MS, late):
        bus.hear(at_ns, 3, Dac(100, 0, 0))
        bus.hear(at_ns, 1, operational)
        seen = bus.facts().reenabled
        assert bool(seen) == (at_ns == late)
    assert seen == [
        "joint 3 asks for torque after its brake has closed",
        "joint 1 says OPERATIONAL after the stop",
    ]
    bus.measure(late, 0.0)
    assert bus.facts().reenabled[-1] == "the brake of joint 3 opened again"


def test_a_process_that_goes_on_answers_the_frames_of_its_sleep_first() -> None:
    back_ns = 20 * CYCLE_NS
    bus = Bus(variant(), node=3, back_ns=back_ns)
    bus.hear(MS, 0, Nmt(Command.QUICKSTOP, 0, 0))
    operational = Heartbeat(NodeState.OPERATIONAL, 0, 0, 1, 0, 0, 0, 0)
    bus.hear(back_ns + MS, 3, operational)
    assert bus.facts().reenabled == []
    bus.hear(back_ns + 3 * CYCLE_NS, 3, operational)
    assert bus.facts().reenabled != []


def test_without_a_plant_the_arm_rests_when_its_torque_is_off() -> None:
    bus = Bus(variant(Expected.R4, "plant"), node=PLANT)
    assert bus.facts().rest is None
    bus.hear(300 * MS, 1, emcy(FaultCode.MEASURE_MISSING, 3, PLANT))
    assert bus.facts().rest == 3.0


# --- when a fault begins to show ------------------------------------------------------------------


def test_a_silence_begins_with_the_cycle_that_lacks_a_frame() -> None:
    before = [Heard(0, 0, Sync(1, 4, 0, 0)), Heard(1, 3, Dac(0, 0, 1))]
    after = [Heard(5, 0, Sync(2, 4, 0, 0)), Heard(6, 2, Dac(0, 0, 2))]
    scene = Scene(before, after, 2)
    assert effect_ns(Shows.SILENCE, scene, 3, 100) == 5
    assert effect_ns(Shows.SILENCE, scene, MASTER, 100) == 105, "a SYNC is due a cycle later"
    assert effect_ns(Shows.AT_ONCE, scene, MASTER, 100) == 2


def test_a_node_that_comes_back_was_silent_all_the_same() -> None:
    before = [Heard(0, 0, Sync(1, 4, 0, 0))]
    after = [Heard(2000, 0, Sync(2, 4, 0, 0))]
    assert effect_ns(Shows.SILENCE, Scene(before, after, 2), MASTER, 100) == 100


def test_a_slow_machine_before_the_fault_is_no_silence_of_a_node() -> None:
    before = [Heard(at, 3, Dac(0, 0, 1)) for at in (0, 500, 1000)]
    after = [Heard(1010, 0, Sync(2, 4, 0, 0)), Heard(5000, 3, Dac(0, 0, 2))]
    assert effect_ns(Shows.SILENCE, Scene(before, after, 1001), 3, 100) == 1010


def test_an_intruder_is_known_by_its_boot_id() -> None:
    def beat(boot: int) -> Heartbeat:
        return Heartbeat(NodeState.PREOP, 0, 0, boot, 0, 0, 0, 0)

    before = [Heard(0, 3, beat(7))]
    after = [Heard(5, 3, beat(7)), Heard(6, 2, beat(9)), Heard(8, 3, beat(8))]
    assert effect_ns(Shows.INTRUSION, Scene(before, after, 2), 3, 100) == 8
    assert effect_ns(Shows.INTRUSION, Scene(before, after[:2], 2), 3, 100) is None


# --- what a process does to itself ----------------------------------------------------------------


def in_a_fork(check: Callable[[], bool]) -> bool:
    """Whether a check holds in another process: what is done to one stays."""
    pid = os.fork()
    if pid == 0:
        code = 1
        try:
            code = 0 if check() else 1
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0


@pytest.mark.parametrize("number", [errno.ENOBUFS, errno.EAGAIN])
def test_the_kernel_refuses_to_send_and_nothing_else(number: int, tmp_path: Path) -> None:
    def check() -> bool:
        one, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        other.send(b"before")
        sends_fail(number)()
        try:
            one.send(b"x")
        except OSError as error:
            (tmp_path / "log").write_text("files are written")
            return error.errno == number and one.recv(10) == b"before"
        return False

    assert in_a_fork(check)


def test_a_hub_port_that_has_no_room_counts_what_is_lost() -> None:
    def check() -> bool:
        port = HubPort.__new__(HubPort)
        port._socket, _other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        port.statistics = Counter()
        sends_fail(errno.EAGAIN)()
        port.send([Wire().sender(Sync).frame(1, 4, 0, 0, 0)])
        return port.statistics == {"tx_overflow": 1}

    assert in_a_fork(check)


def test_the_time_of_day_jumps_and_no_other_clock_does() -> None:
    def check() -> bool:
        before, ticks = time.time(), time.monotonic()
        signal.signal(signal.SIGUSR1, lambda *_: wall_clock_jumps(-1000.0)())
        os.kill(os.getpid(), signal.SIGUSR1)
        jumped = (
            time.time() - before,
            time.time_ns() * 1e-9 - before,
            time.clock_gettime(time.CLOCK_REALTIME) - before,
            time.clock_gettime_ns(time.CLOCK_REALTIME) * 1e-9 - before,
        )
        steady = (time.monotonic(), time.clock_gettime(time.CLOCK_MONOTONIC))
        return all(abs(d + 1000.0) < 5.0 for d in jumped) and all(
            0.0 <= now - ticks < 5.0 for now in steady
        )

    assert in_a_fork(check)
