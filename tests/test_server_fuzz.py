"""What peers may send: anything. The server stays up, refuses with a reason, and the arm moves on.

The motion is compared, set-point by set-point, with that of an undisturbed twin.
"""

import random
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.server import Coordinator, ServerBench, encode

from rfms_can.messages import (
    AtRest,
    CycleReached,
    FeedRequest,
    GripperRequest,
    JointPositionMessage,
    LeaseRequest,
    Linear,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    Query,
    Reply,
    StopRequest,
    Table,
    TableRow,
    TransformMessage,
    WaitRequest,
)
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Setpoint

HOME = Transform.identity()
SERVED_CYCLES = 250
MUTATED_EVERY_CYCLE = 40
POISONED_EVERY_CYCLE = 10

HARMLESS = (
    TransformMessage("unused", HOME),
    TransformMessage("weave", HOME, "functional", Linear((0.0, 0.1, 0.0))),
    TransformMessage(
        "table", HOME, "functional", Table([TableRow(u, (0.0,) * 6) for u in (0.0, 1.0)])
    ),
    TransformMessage("seen", HOME, "reference", predict="velocity", twist=(0.0,) * 6, stamp=0.0),
    PositionMessage("elsewhere", ["t6"], ["unused"], configuration="left up noflip"),
    JointPositionMessage("angles", (0.1, 1.4, -3.3, 0.1, -1.25, 3.5)),
    ModeMessage("slow", "cartesian", 0.2, speed=0.1, lengthen=True),
    MoveRequest("nowhere", "slow"),
    Query("world"),
    WaitRequest([CycleReached(3), AtRest()]),
)
"""Requests that do not change the motion under way, even if they are taken."""

ALL = (
    *HARMLESS,
    StopRequest(),
    FeedRequest(0.5),
    GripperRequest(True),
    LeaseRequest("acquire", "thief", 5.0),
    LeaseRequest("release"),
)

POISON: tuple[Any, ...] = (
    *(float("nan"), float("inf"), -float("inf"), 1e300, -1e300, 1e10, 5e-324, 0.0, -1.0),
    *(
        None,
        True,
        "",
        "t6",
        "x" * 65,
        "\x00",
        b"\xff",
        2**63,
        -(2**63),
        [],
        [[]],
        {},
        {"type": "x"},
    ),
)


@pytest.fixture(scope="module")
def wire() -> Wire:
    return Wire()


@pytest.fixture(scope="module")
def victim(wire: Wire) -> ServerBench:
    """A server whose lease is taken; hypothesis' examples share it."""
    bench = ServerBench(wire)
    Coordinator(bench, "holder").acquire(10.0)
    return bench


def assert_unharmed(bench: ServerBench) -> None:
    status = bench.server.status()
    assert (status.fault, status.phase, status.lease) == (None, "RUN", "holder")
    assert status.at_rest
    assert status.sequence == 0


def assert_has_a_reason(reply: Reply) -> None:
    assert (reply.answer is None) != (reply.refusal is None)
    if reply.refusal is not None:
        assert reply.refusal.error.endswith("Error")
        assert 0 < len(reply.refusal.reason) < 1000
        assert reply.refusal.reason.isprintable(), "one line, and harmless in a terminal"


# --- anything at all --------------------------------------------------------------------------


@settings(max_examples=400)
@given(messages=st.lists(st.binary(max_size=200), min_size=1, max_size=10))
def test_any_bytes(victim: ServerBench, messages: list[bytes]) -> None:
    for data in messages:
        before = victim.server.numbers().refused
        (reply,) = victim.give(data)
        assert reply.serial == 0
        assert reply.refusal is not None
        assert_has_a_reason(reply)
        assert victim.server.numbers().refused == before + 1
        assert victim.hear(victim.server.emergency(data)) == []
    assert_unharmed(victim)


NUMBERS = st.integers(-(2**63), 2**64 - 1) | st.floats()
VALUES = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text(max_size=20) | st.binary(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=12,
)


@settings(max_examples=250)
@given(
    envelope=st.fixed_dictionaries(
        {"session": VALUES | st.just("s" * 16), "serial": VALUES | st.just(1), "message": VALUES}
    )
    | VALUES
)
def test_any_structure(victim: ServerBench, envelope: Any) -> None:
    for reply in victim.give(encode(envelope)):
        assert reply.refusal is not None
        assert_has_a_reason(reply)
    victim.server.emergency(encode(envelope))
    assert_unharmed(victim)


@pytest.mark.parametrize("depth", [10, 1000, 60_000])
@pytest.mark.parametrize("opening", [b"\x91", b"\x81\xa1a"])
def test_nesting_without_end(victim: ServerBench, depth: int, opening: bytes) -> None:
    data = (opening * depth)[:65_000]
    head = encode({"session": "s" * 16, "serial": 1})
    message = bytes([0x83]) + head[1:] + encode("message") + data
    for one in (data, data + b"\xc0", message[:65_536], message[:65_000] + b"\xc0"):
        for reply in victim.give(one):
            assert_has_a_reason(reply)
            assert reply.refusal is not None
        victim.server.emergency(one)
    assert_unharmed(victim)


# --- nearly right -----------------------------------------------------------------------------


class Thief:
    """Says what others say, changed here and there; its sessions are its own."""

    def __init__(self, bench: ServerBench, seed: int) -> None:
        self.bench = bench
        self.rng = random.Random(seed)
        self.others = [Coordinator(bench, f"thief {number}") for number in range(8)]

    def mutated(self) -> bytes:
        """A valid request with some bytes changed, lost, repeated or cut off."""
        rng = self.rng
        one = rng.choice(self.others)
        data = bytearray(one.envelope(rng.choice(ALL), rng.choice((1, one.serial + 1))))
        for _ in range(rng.choice((0, 1, 1, 1, 2, 5))):
            place = rng.randrange(len(data))
            match rng.randrange(5):
                case 0:
                    data[place] ^= 1 << rng.randrange(8)
                case 1:
                    data[place] = rng.randrange(256)
                case 2:
                    del data[place : place + rng.randrange(1, 9)]
                case 3:
                    data[place:place] = data[place : place + rng.randrange(1, 9)]
                case _:
                    del data[max(place, 1) :]
            data = data or bytearray(b"\x00")
        return bytes(data)


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths to everything in a structure."""
    yield path
    if isinstance(value, dict):
        for key, one in value.items():
            yield from leaves(one, (*path, key))
    elif isinstance(value, list):
        for index, one in enumerate(value):
            yield from leaves(one, (*path, index))


def poisoned(rng: random.Random) -> Any:
    """A harmless request with one value replaced, one field more, or one less."""
    message = msgspec.json.decode(msgspec.json.encode(rng.choice(HARMLESS)))
    path = rng.choice(list(leaves(message)))
    if not path:
        return rng.choice(POISON)
    place = message
    for step in path[:-1]:
        place = place[step]
    match rng.randrange(6):
        case 0 if isinstance(place, dict):
            del place[path[-1]]
        case 1 if isinstance(place, dict):
            place["more"] = rng.choice(POISON)
        case 2 if isinstance(place, list):
            place.append(rng.choice(POISON))
        case _:
            place[path[-1]] = rng.choice(POISON)
    return message


def moving(wire: Wire) -> tuple[ServerBench, Coordinator]:
    """An arm on its way."""
    bench = ServerBench(wire)
    holder = Coordinator(bench, "holder").acquire(10.0)
    holder.move(seconds=0.8, z=0.06)
    holder.move("on", seconds=0.6, x=0.02, z=0.05)
    return bench, holder


def setpoints(bench: ServerBench, wire: Wire) -> list[bytes]:
    ids = {wire.id(Setpoint, number) for number in (1, 2)}
    return [frame.data for frame in bench.frames if frame.id in ids]


@pytest.mark.system
def test_ten_thousand_messages_do_not_change_the_motion(wire: Wire) -> None:
    (twin, _), (bench, holder) = moving(wire), moving(wire)
    twin.cycles(SERVED_CYCLES)
    thief, rng = Thief(bench, 1), random.Random(2)
    sent = answered = 0
    for _ in range(SERVED_CYCLES):
        for _ in range(MUTATED_EVERY_CYCLE):
            data = thief.mutated()
            sent += 1
            for reply in bench.give(data, b"thief"):
                assert_has_a_reason(reply)
                answered += reply.answer is not None
            bench.server.emergency(data)
        for _ in range(POISONED_EVERY_CYCLE):
            holder.serial += 1
            request = {
                "session": holder.session,
                "serial": holder.serial,
                "message": poisoned(rng),
            }
            sent += 1
            for reply in bench.give(encode(request), holder.peer):
                assert_has_a_reason(reply)
        bench.cycles()
    numbers = bench.server.numbers()
    print(f"{sent} messages, {numbers.refused} refused, {answered} of others answered")
    assert sent >= 10_000
    assert numbers.refused > sent // 2
    assert numbers.emergencies == 0
    assert bench.server.holder == "holder"
    assert setpoints(bench, wire) == setpoints(twin, wire)
    assert len(setpoints(bench, wire)) >= SERVED_CYCLES
    assert twin.server.status().joints == bench.server.status().joints


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf"), 1.1e9, -1e300])
def test_numbers_that_are_none_are_refused_by_place(victim: ServerBench, value: float) -> None:
    client = Coordinator(victim, f"someone with {value}")
    rows = (*HOME[:11], value)
    for message, place in (
        (TransformMessage("a", rows), r"rows[11]"),
        (TransformMessage("a", HOME, stamp=value), "stamp"),
        (TransformMessage("a", HOME, twist=(0.0, value, 0.0, 0.0, 0.0, 0.0)), "twist[1]"),
        (
            TransformMessage("a", HOME, "functional", Linear(turn=(value, 0.0, 0.0))),
            "function.turn[0]",
        ),
        (
            TransformMessage(
                "a",
                HOME,
                "functional",
                Table([TableRow(0.0, (0.0,) * 6), TableRow(1.0, (0.0,) * 5 + (value,))]),
            ),
            "function.rows[1].coordinates[5]",
        ),
    ):
        refusal = client.refused(message)
        assert refusal.error == "LinkError"
        assert refusal.reason.startswith(f"{place} is {value:g}")
