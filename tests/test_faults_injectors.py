"""Each injector does what it says, and nothing else: frames, taps, boards, strangers."""

import math
import random
from collections.abc import Iterable
from typing import Any

import pytest

from rfms_can.arm import arm_by_name
from rfms_can.bus.disturbance import Disturbance
from rfms_can.faults import boards, frames, nodes
from rfms_can.faults.context import Context
from rfms_can.faults.forge import COUNTER, Forge
from rfms_can.faults.tap import Tap
from rfms_can.node.protocol import NOTHING
from rfms_can.plant.board import HIGHEST_CODE, Board
from rfms_can.plant.faulty_board import ENCODER_FLOOR, Damage, FaultyBoard
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.protection import Refusal
from rfms_can.wire.records import Dac, Heartbeat, JointError, Measure, Rows, Setpoint, Sync

PERIOD_NS = 4_000_000
JOINT = 2


class Site:
    """A context whose clock is set by hand, and that notes the first effect."""

    def __init__(self, wire: Wire) -> None:
        self.now_ns = 0
        self.touched: list[int] = []
        self.context = Context(
            arm=arm_by_name("puma260"),
            period_ns=PERIOD_NS,
            wire=wire,
            forge=Forge(wire),
            draw=random.Random(1),
            node=JOINT,
            now_ns=lambda: self.now_ns,
            touch=lambda at_ns=None: self.touched.append(self.now_ns if at_ns is None else at_ns),
        )


@pytest.fixture
def site(wire: Wire) -> Site:
    return Site(wire)


class Node:
    """Sends what it hears, and what it is given at its deadline."""

    name = "node"
    echo = True
    accepts = frozenset((1, 2))

    def __init__(self, *sends: Frame) -> None:
        self.sends = sends
        self.heard: list[Frame] = []

    def on_frame(self, frame: Frame, now_ns: int) -> Iterable[Frame]:
        self.heard.append(frame)
        return (frame,)

    def on_time(self, now_ns: int) -> Iterable[Frame]:
        return self.sends

    def next_deadline_ns(self) -> int | None:
        return 7


def sent(wire: Wire, record: type[Any], count: int, node: int | None = JOINT) -> list[Frame]:
    """Frames of a message with zeros, as a good node sends them."""
    sender = wire.sender(record, node)
    width = len(record._fields)
    return [sender.frame(*[0] * width) for _ in range(count)]


def setpoints(wire: Wire, count: int) -> list[Frame]:
    """The same pose in some frames."""
    sender = wire.sender(Setpoint, 1)
    pose = Setpoint(*[0] * 20)._replace(o_y=1.0, a_z=1.0, p_x=0.3, p_z=0.1, poses=1)
    return [sender.frame(*pose) for _ in range(count)]


# --- frames on the bus ----------------------------------------------------------------------------


def verdicts(site: Site, make: frames.Make, on: list[Frame]) -> list[Disturbance | None]:
    disturb = make(site.context)
    return [disturb(0, frame, "sender") for frame in on]


def test_one_frame_of_one_message_is_disturbed(site: Site, wire: Wire) -> None:
    other = sent(wire, Dac, 1, node=JOINT + 1)
    mine = sent(wire, Dac, 3)
    told = verdicts(site, frames.of_message(Dac, frames.lost), [*other, *mine])
    assert told[0] is None
    assert told[1] is not None
    assert "plant" in told[1].lost_at
    assert told[2:] == [None, None]
    assert len(site.touched) == 1


def test_a_burst_and_every_third(site: Site, wire: Wire) -> None:
    burst = verdicts(site, frames.of_message(Dac, frames.lost, 5), sent(wire, Dac, 8))
    assert [v is not None for v in burst] == [True] * 5 + [False] * 3
    often = verdicts(site, frames.of_message(Dac, frames.corrupt, 99, 3), sent(wire, Dac, 7))
    assert [v is not None for v in often] == [True, False, False] * 2 + [True]


def test_payloads_are_what_the_receivers_refuse(wire: Wire) -> None:
    (frame,) = sent(wire, Dac, 1)
    decoder = wire.receiver(Dac, JOINT).decoder
    for verdict, refusal in (
        (frames.corrupt, Refusal.CRC),
        (frames.short, Refusal.LENGTH),
        (frames.long, Refusal.LENGTH),
        (frames.classic, Refusal.KIND),
    ):
        disturbance = verdict(frame)
        data = frame.data if disturbance.data is None else disturbance.data
        fd = True if disturbance.fd is None else disturbance.fd
        assert decoder.decode(Frame(frame.id, data, fd)) is refusal


def test_copies_and_delays(site: Site, wire: Wire) -> None:
    (frame,) = sent(wire, Dac, 1)
    assert frames.copied(frame).copies == 1
    (told,) = verdicts(site, frames.late(1.5, Dac), [frame])
    assert told is not None
    assert told.delay_ns == 6_000_000


def test_a_deaf_node_hears_again_after_its_time(site: Site, wire: Wire) -> None:
    disturb = frames.deaf(9, cycles=2)(site.context)
    (frame,) = sent(wire, Dac, 1)
    assert disturb(0, frame, "plant") is None, "what it sends itself goes out"
    told = disturb(0, frame, "joint 2")
    assert told is not None
    assert set(told.lost_at) == {"plant"}  # type: ignore[call-overload]
    assert disturb(2 * PERIOD_NS, frame, "joint 2") is None


# --- a tap at a node ------------------------------------------------------------------------------


def through(tap: Tap, frame: Frame) -> list[Frame]:
    return list(tap.on_frame(frame, 0))


def test_a_tap_that_does_nothing_is_not_there(wire: Wire) -> None:
    (frame,) = sent(wire, Dac, 1)
    node = Node(frame)
    tap = Tap(node)  # type: ignore[arg-type]
    assert (tap.name, tap.accepts, tap.echo, tap.next_deadline_ns()) == (
        node.name,
        node.accepts,
        True,
        7,
    )
    assert through(tap, frame) == [frame]
    assert list(tap.on_time(0)) == [frame]


def test_a_hung_node_does_nothing_from_the_next_frame_on(site: Site, wire: Wire) -> None:
    node = Node()
    tap = Tap(node)  # type: ignore[arg-type]
    nodes.hangs(site.context, tap)
    site.now_ns = 5
    (frame,) = sent(wire, Dac, 1)
    assert site.touched == []
    assert through(tap, frame) == []
    assert site.touched == [5]
    assert through(tap, frame) == []
    assert (node.heard, tap.on_time(0), tap.next_deadline_ns()) == ([], NOTHING, None)
    tap.hung = False
    assert through(tap, frame) == [frame], "it can wake"


def test_a_master_that_ends_has_its_effect_at_its_next_deadline(site: Site) -> None:
    tap = Tap(Node())  # type: ignore[arg-type]
    nodes.stops_at_its_deadline(site.context, tap)
    assert site.touched == [7]
    assert tap.next_deadline_ns() is None


def tapped(site: Site, install: nodes.Install, into: list[Frame]) -> list[Frame]:
    tap = Tap(Node())  # type: ignore[arg-type]
    install(site.context, tap)
    return [out for frame in into for out in through(tap, frame)]


def test_forged_values_pass_the_receiver(site: Site, wire: Wire) -> None:
    receiver = wire.receiver(Rows, JOINT)
    change = nodes.values(lambda _, rows: {"gravity": rows.gravity + 1.5})
    out = tapped(site, nodes.sends(Rows, change), sent(wire, Rows, 3))
    taken = [receiver.take(frame) for frame in out]
    assert [rows.gravity for rows in taken if rows is not None] == [1.5] * 3
    assert (receiver.lost, sum(receiver.bad.values())) == (0, 0)


def test_only_so_many_frames_are_forged(site: Site, wire: Wire) -> None:
    change = nodes.number("p_x", nodes.NAN)
    out = tapped(site, nodes.sends(Setpoint, change, 1), setpoints(wire, 2))
    decoder = wire.receiver(Setpoint, 1).decoder
    told = [decoder.decode(frame) for frame in out]
    assert told[0] is Refusal.RANGE
    assert told[1] is not Refusal.RANGE


def test_a_number_that_no_codec_sends_has_a_right_crc(site: Site, wire: Wire) -> None:
    for value in (math.nan, 50.0):
        (frame,) = sent(wire, JointError, 1)
        patched = site.context.forge.patched(frame, "error", value)
        assert wire.receiver(JointError, JOINT).decoder.decode(patched) is Refusal.RANGE
        assert patched.data[COUNTER] == frame.data[COUNTER]


def test_a_stuck_counter_and_a_stuck_value(site: Site, wire: Wire) -> None:
    sender = wire.sender(Dac, JOINT)
    into = [sender.frame(100 + cycle, 0, cycle) for cycle in range(4)]
    stuck = tapped(site, nodes.same_frame(Dac), into)
    assert stuck == [into[0]] * 4
    receiver = wire.receiver(Dac, JOINT)
    frozen = tapped(site, nodes.same_values(Dac, ("cycle",)), into)
    taken = [receiver.take(frame) for frame in frozen]
    assert [(dac.current_dac, dac.cycle) for dac in taken if dac is not None] == [
        (100, cycle) for cycle in range(4)
    ]
    assert receiver.lost == 0


def test_a_babbling_node_counts_each_frame(site: Site, wire: Wire) -> None:
    receiver = wire.receiver(JointError, JOINT)
    out = tapped(site, nodes.babbles(JointError, JointError), sent(wire, JointError, 3))
    assert len(out) == 3 * nodes.BABBLE[JointError]
    assert all(receiver.take(frame) is not None for frame in out)
    assert receiver.lost == 0
    beats = [*sent(wire, Heartbeat, 1), *sent(wire, JointError, 2)]
    out = tapped(site, nodes.babbles(Heartbeat, JointError), beats)
    assert len(out) == len(beats) + 2 * (nodes.BABBLE[Heartbeat] - 1)


def test_another_hash_and_a_turned_pose(site: Site, wire: Wire) -> None:
    (sync,) = tapped(
        site, nodes.sends(Sync, nodes.values(nodes.other_hash)), sent(wire, Sync, 1, None)
    )
    assert site.context.forge.read(sync).dbc_hash == 0x0F00
    out = tapped(site, nodes.runs_on, setpoints(wire, 100))
    last = site.context.forge.read(out[-1])
    angle = 100 * nodes.DRIFT_FRACTION * site.context.speed_limit * site.context.period_s
    assert math.atan2(last.p_y, last.p_x) == pytest.approx(angle, abs=1e-6)
    assert (last.p_z, math.hypot(last.o_x, last.o_y)) == pytest.approx((0.1, 1.0))


# --- the board of a joint -------------------------------------------------------------------------


def board(damage: Damage, effects: list[int] | None = None) -> FaultyBoard:
    effects = [] if effects is None else effects
    return FaultyBoard(
        Board(arm_by_name("puma260"), JOINT - 1, 0.0), damage, lambda: effects.append(1)
    )


def samples(faulty: FaultyBoard, angles: Iterable[float], speed: float = 0.5) -> list[Any]:
    out = []
    for angle in angles:
        faulty.observe(angle, speed)
        out.append(faulty.sample())
    return out


ANGLES = [0.001 * n for n in range(30)]


def test_a_board_without_damage_is_sound() -> None:
    effects: list[int] = []
    whole = Board(arm_by_name("puma260"), JOINT - 1, 0.0)
    faulty = board(Damage(), effects)
    for angle in ANGLES:
        whole.observe(angle, 0.5)
        faulty.observe(angle, 0.5)
        assert faulty.sample() == whole.sample()
        assert faulty.coarse(angle) == whole.coarse(angle)
        assert faulty.set_dacs(100, 20) == whole.set_dacs(100, 20)
        assert faulty.latched_index_counts == whole.latched_index_counts
    assert effects == []


def test_encoders(site: Site) -> None:
    sound = [s[0] for s in samples(board(Damage()), ANGLES)]

    def counts(damage: Damage) -> list[int]:
        return [s[0] for s in samples(board(damage), ANGLES)]

    assert set(counts(boards.frozen_encoder(site.context))) == {sound[0]}
    assert counts(boards.reversed_encoder(site.context)) == [2 * sound[0] - c for c in sound]
    off = [a - b for a, b in zip(counts(boards.glitch(site.context)), sound, strict=True)]
    assert abs(off[0]) > abs(site.context.counts(1.5 * 1.5 * site.context.period_s))
    assert set(off[1:]) == {0}
    off = [a - b for a, b in zip(counts(boards.jump(site.context)), sound, strict=True)]
    assert {abs(o) for o in off} == {abs(site.context.counts(boards.JUMP_RAD))}
    off = [a - b for a, b in zip(counts(boards.drift(site.context)), sound, strict=True)]
    assert sorted(map(abs, off)) == [abs(o) for o in off], "it grows"


def test_the_effect_is_told_beyond_the_noise_floor_only() -> None:
    effects: list[int] = []
    faulty = board(Damage(counts=lambda age, counts: counts + min(age, ENCODER_FLOOR + 1)), effects)
    samples(faulty, ANGLES[: ENCODER_FLOOR + 1])
    assert effects == []
    samples(faulty, ANGLES[:1])
    assert effects == [1]


def test_tachometer_current_and_coarse_position(site: Site) -> None:
    context = site.context
    faulty = board(boards.reversed_tachometer(context))
    ((_, _, speed, _),) = samples(faulty, [0.0])
    ((_, _, sound, _),) = samples(board(Damage()), [0.0])
    assert speed == -sound != 0
    ((_, _, speed, _),) = samples(board(boards.velocity_rail(context)), [0.0])
    assert abs(speed) >= HIGHEST_CODE
    ((_, current, _, _),) = samples(board(boards.current_rail(context)), [0.0])
    assert current == HIGHEST_CODE
    turned = board(boards.turned_potentiometer(context)).coarse(0.0)
    interval = context.arm.drives[context.index].index_interval
    per_code = context.arm.board_scale(context.index).angle_per_coarse_code
    intervals = (turned - board(Damage()).coarse(0.0)) * per_code / interval
    assert 0.35 < abs(intervals) % 1.0 < 0.65, "between two indexes"
    frozen = board(boards.frozen_tachometer(context))
    samples(frozen, [0.0], 0.5)
    ((_, _, kept, _),) = samples(frozen, [0.0], -0.5)
    assert kept == sound


def test_amplifiers_and_motors(site: Site) -> None:
    context = site.context
    sound = board(Damage()).set_dacs(200)
    assert board(boards.reversed_motor(context)).set_dacs(200) == -sound
    assert board(boards.dead_amplifier(context)).set_dacs(200) == 0.0
    assert board(boards.strong_amplifier(context)).set_dacs(200) == pytest.approx(4.0 * sound)
    stuck = board(boards.stuck_amplifier(context))
    assert stuck.set_dacs(200) == stuck.set_dacs(-700)
    assert board(boards.amplifier_drives_up(context)).set_dacs(0) > 0.0, "towards larger angles"


def test_measure_is_about_the_joint_at_fault(site: Site, wire: Wire) -> None:
    assert frames.identifier(site.context, Measure) == wire.id(Measure, JOINT)
    assert frames.identifier(site.context, Sync) == wire.id(Sync)
