"""Damaged and disguised frames, exhaustively: every one- and two-bit error is refused."""

import itertools

import pytest
from support.wire_messages import PROTECTED, every_protected_message, frames_of

from rfms_can.errors import EncodeError
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.protection import Decoder, Refusal
from rfms_can.wire.records import Dac, Estop, Setpoint


@every_protected_message
def test_every_one_and_two_bit_error_is_refused(wire: Wire, name: str) -> None:
    """Exhaustive: 130,816 pairs for 64 bytes. A CRC is linear, so one payload speaks for all."""
    codec = wire.codecs[name]
    decoder, good = Decoder(codec), frames_of(codec, 1)[0]
    assert decoder.decode(good).__class__ is not Refusal
    length, word = len(good.data), int.from_bytes(good.data, "little")
    bits = [1 << bit for bit in range(8 * length)]
    decode, identifier, wrong = decoder.decode, good.id, Refusal.CRC
    accepted = [
        flips
        for flips in itertools.chain(bits, map(sum, itertools.combinations(bits, 2)))
        if decode(Frame(identifier, (word ^ flips).to_bytes(length, "little"))) is not wrong
    ]
    assert accepted == []


def test_every_three_bit_error_of_a_torque_command_is_refused(wire: Wire) -> None:
    codec = wire.codec(Dac, 1)
    decoder, good = Decoder(codec), frames_of(codec, 1)[0]
    word = int.from_bytes(good.data, "little")
    for flips in map(sum, itertools.combinations([1 << bit for bit in range(64)], 3)):
        assert decoder.decode(Frame(good.id, (word ^ flips).to_bytes(8, "little"))) is Refusal.CRC


@every_protected_message
def test_every_burst_of_up_to_a_crcs_length_is_refused(wire: Wire, name: str) -> None:
    codec = wire.codecs[name]
    decoder, good = Decoder(codec), frames_of(codec, 1)[0]
    length, word = len(good.data), int.from_bytes(good.data, "little")
    for start in range(8 * length - 15):
        for burst in (0xFFFF, 0xA5A5, 0x8001):
            damaged = (word ^ burst << start).to_bytes(length, "little")
            assert decoder.decode(Frame(good.id, damaged)) is Refusal.CRC


def test_bytes_of_one_message_are_refused_under_every_other_id(wire: Wire) -> None:
    codecs = [wire.codecs[name] for name in PROTECTED]
    frames = [(codec, frames_of(codec, 1)[0]) for codec in codecs]
    for codec, frame in frames:
        for other in codecs:
            if other is not codec and other.length == codec.length:
                under_other_id = Frame(other.id, frame.data)
                assert Decoder(other).decode(under_other_id) is Refusal.CRC, (
                    codec.name,
                    other.name,
                )


def test_a_set_point_is_not_taken_for_the_second_pose(wire: Wire) -> None:
    frame = frames_of(wire.codec(Setpoint, 1), 1)[0]
    assert wire.receiver(Setpoint, 1).take(frame) is not None
    receiver = wire.receiver(Setpoint, 2)
    assert receiver.take(frame) is None
    assert receiver.refused == {Refusal.CRC: 1}


def test_the_emergency_stop_is_one_constant_payload(wire: Wire) -> None:
    frame = wire.sender(Estop).frame(*ESTOP_VALUES)
    assert frame == Frame(0x000, b"STOP" + bytes(byte ^ 0xFF for byte in b"STOP"))
    receiver = wire.receiver(Estop)
    for _ in range(3):  # any sender, any number of times
        assert receiver.take(frame) == ESTOP_VALUES
    with pytest.raises(EncodeError, match=r"^ESTOP\.code"):
        wire.sender(Estop).frame(0, 0)


def test_no_other_payload_stops_the_arm(wire: Wire) -> None:
    receiver = wire.receiver(Estop)
    word = int.from_bytes(b"STOP" + bytes(byte ^ 0xFF for byte in b"STOP"), "little")
    bits = [1 << bit for bit in range(64)]
    damaged = [*bits, *map(sum, itertools.combinations(bits, 2)), word]
    for flips in damaged:
        assert receiver.take(Frame(0x000, (word ^ flips).to_bytes(8, "little"))) is None
    assert receiver.refused == {Refusal.RANGE: len(damaged)}
