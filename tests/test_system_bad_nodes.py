"""Bad nodes in a whole system: whatever they tell, the run ends with exit code 1 and names them.

Each is joint 3 of ``examples/transfer.py`` on the simulated bus, which a good one ends with 0.
"""

import math
import re
from collections.abc import Callable, Iterable
from typing import Any

import pytest
from support.bad_nodes import (
    BAD,
    Begun,
    Make,
    Mirrored,
    OtherHash,
    Tampered,
    Unwatched,
    replace_joint,
    restarts,
    tampered,
    without,
)
from support.bench import Heard, Reader
from support.command_line import Ended, Rfms
from support.system import TRANSFER

from rfms_can.joint_nodes.joint import JointNode
from rfms_can.master.phases import Phase
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import (
    ConfigAck,
    Dac,
    Emcy,
    Heartbeat,
    JointError,
    Measure,
    Reference,
    Sync,
)
from rfms_can.wire.vocabulary import FaultCode, NodeState

pytestmark = pytest.mark.system

FAR_RAD = math.radians(2.0)
"""A joint that is stopped is not farther than this from where it was commanded to be."""


class Halted:
    """How a run with a bad node has ended.

    Attributes:
        complaint: the last line it printed.
        rig: its nodes.
        said: what was sent as joint 3, in order.
        worst: largest distance of a joint from the commanded angle while enabled, rad.
    """

    def __init__(self, ended: Ended, watch: "Watch") -> None:
        assert ended.code == 1, ended.err
        self.complaint = ended.err.strip().splitlines()[-1]
        assert self.complaint.startswith("rfms: ")
        self.rig, self.said, self.worst = watch.rig, watch.said, watch.worst

    @property
    def cycles(self) -> int:
        """Cycles while enabled."""
        return self.rig.master.statistics.cycles

    def assert_torque_off(self) -> None:
        """One DAC of 0 follows its EMCY, and none after that until RESET."""
        names = [said.name for said in self.said]
        after = self.said[names.index(f"EMCY_{BAD}") :]
        assert [said.values.current_dac for said in after if said.name == f"DAC_{BAD}"] == [0]


class Watch:
    """Sees what is sent as joint 3, and where the arm is."""

    def __init__(self, rig: SimulatedRig) -> None:
        self.rig = rig
        self.said: list[Heard] = []
        self.worst = 0.0
        self._reader = Reader(rig.master.wire)
        self._own = {rig.master.wire.id(record, BAD) for record in (Heartbeat, Emcy, Dac)}
        self._sync = rig.master.wire.id(Sync)
        rig.bus.observers.append(self._look)

    def _look(self, _: int, frame: Frame, _sender: str) -> None:
        master = self.rig.master
        if frame.id in self._own and len(frame.data) in (8, 20):
            codec = next(c for c in master.wire.codecs.values() if c.id == frame.id)
            if codec.unpack(frame.data) is not None:
                self.said.append(self._reader.read(frame))
        elif frame.id == self._sync and master.phase is Phase.RUN:
            q, goal = self.rig.plant.physics.model.q, master.motion.commanded.theta
            off = max(abs(a - b) for a, b in zip(q, goal, strict=True))
            self.worst = max(self.worst, off)


Halts = Callable[..., Halted]


@pytest.fixture
def halts(rfms: Rfms, monkeypatch: pytest.MonkeyPatch) -> Halts:
    """Runs the transfer with a bad joint, which must end with exit code 1."""

    def run(make: Make, *flags: str) -> Halted:
        watches: list[Watch] = []
        replace_joint(monkeypatch, make, lambda rig: watches.append(Watch(rig)))
        return Halted(rfms("run", TRANSFER, *flags), watches[-1])

    return run


def test_a_good_node_in_its_place_is_none(rfms: Rfms, monkeypatch: pytest.MonkeyPatch) -> None:
    """The wrapper alone changes nothing."""
    replace_joint(monkeypatch, tampered())
    assert rfms("run", TRANSFER).code == 0


# --- what moves, and where it says it is ---------------------------------------------------------


def test_mirrored_inverse_kinematics_is_stopped_in_the_first_cycles_of_motion(
    halts: Halts,
) -> None:
    ended = halts(Mirrored)
    assert "joint 3: ERROR_3 tells " in ended.complaint
    assert "its node computes another set-point" in ended.complaint
    moving = ended.rig.master.statistics.moving[BAD - 1]
    assert moving.count < 40
    assert ended.worst < math.radians(0.2)


NAMED = re.compile(r"rfms: joint 3(: AMPLIFIER_FAULT \(| does not follow: MEASURE_3 is )")


@pytest.mark.parametrize("kind", [Tampered, Unwatched])
def test_dac_0_from_cycle_50_on_is_stopped(halts: Halts, kind: type[Tampered]) -> None:
    """Its own node reads no current; the master sees the joint sink where the node does not."""

    def no_torque(node: Tampered, frame: Frame) -> Iterable[Frame]:
        if node.is_a(frame, Dac) and node.enabled_cycles >= 50:
            return (node.changed(frame, Dac, current_dac=0, force_dac=0),)
        return (frame,)

    ended = halts(tampered(no_torque, kind=kind))
    assert ("AMPLIFIER" if kind is Tampered else "does not follow") in ended.complaint
    assert NAMED.match(ended.complaint), ended.complaint
    assert ended.worst < math.radians(6.0)  # the master's bound is 3.8 degrees for this joint


def test_error_always_0_is_contradicted_by_measure(halts: Halts) -> None:
    def perfect(node: Tampered, frame: Frame) -> Iterable[Frame]:
        if node.is_a(frame, JointError):
            return (node.changed(frame, JointError, error=0.0, error_rate=0.0, acceleration=0.0),)
        return (frame,)

    ended = halts(tampered(perfect))
    assert "joint 3: ERROR_3 tells 0.000000 rad, but MEASURE_3 is " in ended.complaint
    assert ended.worst < math.radians(0.2)


def reversed_from(cycle: int) -> Callable[[Tampered, Frame], Iterable[Frame]]:
    """A motor or amplifier that is turned round, from a cycle of motion on; -1: always."""

    def reverse(node: Tampered, frame: Frame) -> Iterable[Frame]:
        if node.is_a(frame, Dac) and node.enabled_cycles >= cycle:
            dac: Any = node.wire.codec(Dac, BAD).unpack(frame.data)
            return (node.changed(frame, Dac, current_dac=min(2047, -dac.current_dac)),)
        return (frame,)

    return reverse


def test_a_joint_that_runs_off_although_commanded_to_rest_loses_its_torque(halts: Halts) -> None:
    ended = halts(tampered(reversed_from(20)))
    assert "joint 3: AMPLIFIER_FAULT (" in ended.complaint
    ended.assert_torque_off()
    assert ended.cycles < 60
    assert ended.worst < FAR_RAD


def test_it_is_named_too_where_its_own_node_does_not_notice(halts: Halts) -> None:
    ended = halts(tampered(reversed_from(20), kind=Unwatched))
    assert re.search(r"joint 3( does not follow|: ENCODER_GLITCH)", ended.complaint)
    assert ended.cycles < 60


# --- before START --------------------------------------------------------------------------------


def test_another_configuration_hash_in_every_heartbeat_is_refused_before_start(
    halts: Halts,
) -> None:
    def hash_1(node: Tampered, frame: Frame) -> Iterable[Frame]:
        return (
            (node.changed(frame, Heartbeat, config_hash=1),)
            if node.is_a(frame, Heartbeat)
            else (frame,)
        )

    ended = halts(tampered(hash_1))
    assert "joint 3 holds configuration 0x0001, not 0x" in ended.complaint
    assert ended.cycles == 0


def test_an_acknowledgement_that_echoes_another_value_is_refused_before_start(
    halts: Halts,
) -> None:
    def other_value(node: Tampered, frame: Frame) -> Iterable[Frame]:
        if not node.is_a(frame, ConfigAck):
            return (frame,)
        ack = node.wire.codec(ConfigAck, BAD).unpack(frame.data)
        assert ack is not None
        return (node.changed(frame, ConfigAck, value=1.5 * ack.value),)

    ended = halts(tampered(other_value))
    assert "joint 3 acknowledges ARM_ID = 390, sent was 260" in ended.complaint
    assert ended.cycles == 0


def test_a_node_that_is_never_ready_is_named_when_its_time_is_over(halts: Halts) -> None:
    def never(node: Tampered, frame: Frame) -> Iterable[Frame]:
        if node.is_a(frame, Heartbeat) and node.state is NodeState.READY:
            return (node.changed(frame, Heartbeat, state=NodeState.HOMING),)
        return (frame,)

    ended = halts(tampered(never))
    assert re.search(r"not READY after \d+ cycles of homing: joint 3 \(HOMING\)", ended.complaint)
    assert ended.cycles == 0


@pytest.mark.parametrize("record", [Measure, Reference])
def test_frozen_encoder_while_homing_fails_within_a_bound(
    halts: Halts, record: type[Measure] | type[Reference]
) -> None:
    """Its samples never change while it homes; or its index never comes."""
    first: list[bytes] = []

    def frozen(node: Tampered, frame: Frame) -> Iterable[Frame]:
        if not node.is_a(frame, record):
            return (frame,)
        first.append(frame.data)
        codec = node.wire.codec(record, BAD)
        old, now = codec.unpack(first[0]), codec.unpack(frame.data)
        assert old is not None and now is not None
        if record is Measure:
            return (node.changed(frame, Measure, counts=old.counts),)  # type: ignore[union-attr]
        return (node.changed(frame, Reference, index_valid=0),)

    ended = halts(tampered(into=frozen))
    assert re.search(r"joint 3: (SENSOR_MISMATCH|HOMING_FAILED) \(", ended.complaint)
    assert ended.cycles == 0
    ended.assert_torque_off()
    assert ended.rig.master.closed < 1000


def test_reversed_motor_while_homing_ends_before_it_is_fast(halts: Halts) -> None:
    ended = halts(tampered(reversed_from(-1)))
    assert re.search(r"joint 3: (RUNAWAY|AMPLIFIER_FAULT) \(", ended.complaint)
    ended.assert_torque_off()
    assert ended.cycles == 0


# --- frames --------------------------------------------------------------------------------------


def bad_crc(_node: Tampered, frame: Frame) -> Iterable[Frame]:
    return (Frame(frame.id, bytes((frame.data[0] ^ 1, *frame.data[1:]))),)


def too_long(_node: Tampered, frame: Frame) -> Iterable[Frame]:
    return (Frame(frame.id, frame.data + bytes(4)),)


@pytest.mark.parametrize(
    ("tamper", "why"), [(bad_crc, "wrong CRC"), (too_long, "wrong length")], ids=["crc", "length"]
)
def test_bad_frames_are_counted_and_told(
    halts: Halts, tamper: Callable[[Tampered, Frame], Iterable[Frame]], why: str
) -> None:
    ended = halts(tampered(tamper), "--patience", "2")
    assert "not on the bus: joint 3; " in ended.complaint
    assert re.search(rf"; \d+ bad frames came from joint 3 \(\d+ x {why}\)$", ended.complaint)


def test_bad_frames_in_motion_are_told_of_their_sender(halts: Halts) -> None:
    def later(node: Tampered, frame: Frame) -> Iterable[Frame]:
        return bad_crc(node, frame) if node.enabled_cycles >= 30 else (frame,)

    ended = halts(tampered(later))
    assert "BAD_FRAMES (3, bound 10): ERROR_3 of joint 3" in ended.complaint


# --- two of them ---------------------------------------------------------------------------------


class Second(JointNode):
    """Another joint 3; on the simulated bus names tell senders apart."""

    def __init__(self, wire: Wire, boot_id: int) -> None:
        super().__init__(BAD, wire, boot_id)
        self.name = "the second joint 3"


def with_second(boot_id: int, at_cycle: int | None, rigs: list[SimulatedRig]) -> Begun:
    """Another joint 3 on every simulated bus: from power-up, or from a cycle of motion on."""

    def both(rig: SimulatedRig) -> None:
        rigs.append(rig)
        second = Second(rig.master.wire, boot_id)
        rig.joints.append(second)
        if at_cycle is None:  # a process of its own: never quite at the same instant
            rig.bus.attach(second, latency_ns=20_000)
            return

        def appear(*_: object) -> None:
            if rig.master.statistics.cycles == at_cycle and second.cycle < 0:
                second.cycle = 0
                rig.bus.attach(second)

        rig.bus.observers.append(appear)

    return both


def emergencies_of(rig: SimulatedRig) -> list[tuple[str, int]]:
    """Sender's name and fault of every EMCY_3 from now on."""
    told: list[tuple[str, int]] = []
    codec = rig.master.wire.codec(Emcy, BAD)

    def look(_: int, frame: Frame, sender: str) -> None:
        if frame.id == codec.id:
            values: Any = codec.unpack(frame.data)
            told.append((sender, values.fault))

    rig.bus.observers.append(look)
    return told


def test_a_second_node_of_a_number_in_motion_quickstops_it(
    rfms: Rfms, monkeypatch: pytest.MonkeyPatch
) -> None:
    rigs: list[SimulatedRig] = []
    told: list[list[tuple[str, int]]] = []
    second = with_second(0xB007, 60, rigs)

    def both(rig: SimulatedRig) -> None:
        second(rig)
        told.append(emergencies_of(rig))

    replace_joint(monkeypatch, tampered(), both)
    ended = rfms("run", TRANSFER)
    assert ended.code == 1
    assert re.search(r"joint 3: DUPLICATE_NODE \(1\): \w+_3$", ended.err.strip())
    assert set(told[0]) == {
        ("joint 3", FaultCode.DUPLICATE_NODE),
        ("the second joint 3", FaultCode.DUPLICATE_NODE),
    }
    assert rigs[0].joints[-1].state is NodeState.PREOP
    assert rigs[0].master.statistics.cycles < 80


@pytest.mark.parametrize("boot_id", [0xB007, 0x103], ids=["another", "the same boot id"])
def test_a_second_node_of_a_number_is_named_before_anything_moves(
    rfms: Rfms, monkeypatch: pytest.MonkeyPatch, boot_id: int
) -> None:
    rigs: list[SimulatedRig] = []
    replace_joint(monkeypatch, tampered(), with_second(boot_id, None, rigs))
    ended = rfms("run", TRANSFER)
    assert ended.code == 1, ended.err
    assert "joint 3: DUPLICATE_NODE" in ended.err.splitlines()[-1]
    assert rigs[0].master.statistics.cycles == 0
    for joint in (rigs[0].joints[BAD - 1], rigs[0].joints[-1]):
        assert joint.state is NodeState.PREOP


# --- what was found before, and still is ---------------------------------------------------------


def old_dac(node: Tampered, frame: Frame) -> Iterable[Frame]:
    if node.is_a(frame, Dac) and node.enabled_cycles >= 50:
        dac = node.wire.codec(Dac, BAD).unpack(frame.data)
        assert dac is not None
        return (node.changed(frame, Dac, cycle=dac.cycle - 1 & 0xFF),)
    return (frame,)


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (OtherHash, "joint 3 runs another DBC"),
        (without(ConfigAck), "no answer to CONFIG from joint 3"),
        (without(JointError), "joint 3: no ERROR_3 for 3 cycles"),
        (without(Dac), "joint 3: no DAC_3 for 3 cycles"),
        (tampered(old_dac), "joint 3: no DAC_3 for 3 cycles"),
        (without(Heartbeat), "not on the bus: joint 3"),
        (restarts(40), "joint 3 restarted while the bus was up"),
    ],
    ids=["dbc hash", "no ack", "no error", "no dac", "old dac", "no heartbeat", "restart"],
)
def test_what_was_found_is_found(halts: Halts, make: Make, complaint: str) -> None:
    assert complaint in halts(make, "--patience", "2").complaint
