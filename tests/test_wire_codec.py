"""Packing and unpacking of every message, with cantools as the oracle."""

import struct
from typing import Any

import pytest
from cantools.database.can import Message, Signal
from hypothesis import given, settings
from hypothesis import strategies as st
from support.wire_messages import (
    MESSAGES,
    every_message,
    is_taken,
    known_of,
    oracle,
    pack,
    payload_of,
    quiet_values,
)

from rfms_can.errors import EncodeError, FrameError
from rfms_can.wire.codec import MessageCodec
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import FD_LENGTHS, Frame
from rfms_can.wire.protection import Decoder, Refusal, Sender

NO_NUMBERS = (float("nan"), float("inf"), float("-inf"))


def codec_of(wire: Wire, message: Message) -> MessageCodec[Any]:
    return wire.codecs[message.name]


def any_values(message: Message) -> st.SearchStrategy[tuple[float, ...]]:
    """Values our own code may pack: doubles where the wire has float32, any step of a scale."""

    def of(signal: Signal) -> st.SearchStrategy[float]:
        if signal.is_float or signal.conversion.scale != 1:
            return st.floats(signal.minimum, signal.maximum)
        known = known_of(signal)
        return st.sampled_from(known) if known else st.integers(signal.minimum, signal.maximum)

    return st.tuples(*map(of, payload_of(message)))


def raw_bounds(signal: Signal) -> tuple[float, float]:
    conversion = signal.conversion
    low = conversion.numeric_scaled_to_raw(signal.minimum)
    high = conversion.numeric_scaled_to_raw(signal.maximum)
    return low, high


def raw_limits(signal: Signal) -> tuple[float, float]:
    """What the signal's bits can hold."""
    if signal.is_float:
        return struct.unpack("<2f", struct.pack("<2I", 0xFF7FFFFF, 0x7F7FFFFF))
    low = -(1 << signal.length - 1) if signal.is_signed else 0
    return low, low + (1 << signal.length) - 1


def next_float32(value: float, toward: int) -> float:
    """The float32 next to ``value``, up (+1) or down (-1)."""
    if value == 0:
        return toward * 2.0**-149
    bits: int = struct.unpack("<i", struct.pack("<f", value))[0]
    step = toward if value > 0 else -toward
    neighbour: float = struct.unpack("<f", struct.pack("<i", bits + step))[0]
    return neighbour


@every_message
@settings(max_examples=20)
@given(data=st.data())
def test_packs_what_cantools_packs_and_leaves_the_header(
    wire: Wire, message: Message, data: st.DataObject
) -> None:
    names = [signal.name for signal in payload_of(message)]
    values = dict(zip(names, data.draw(any_values(message)), strict=True))
    assert pack(codec_of(wire, message), values) == oracle(message, values)


@every_message
@settings(max_examples=20)
@given(data=st.data())
def test_unpacks_what_cantools_unpacks(wire: Wire, message: Message, data: st.DataObject) -> None:
    codec = codec_of(wire, message)
    names = [signal.name for signal in payload_of(message)]
    payload = oracle(message, dict(zip(names, data.draw(any_values(message)), strict=True)))
    decoded = message.decode(payload, decode_choices=False)
    values = codec.unpack(payload)
    assert values == tuple(decoded[name] for name in names)
    assert pack(codec, values._asdict()) == payload


@every_message
@settings(max_examples=20)
@given(data=st.data())
def test_any_bytes_are_unpacked_as_cantools_does_or_refused_for_their_range(
    wire: Wire, message: Message, data: st.DataObject
) -> None:
    payload = data.draw(st.binary(min_size=message.length, max_size=message.length))
    decoded = message.decode(payload, decode_choices=False)
    signals = payload_of(message)
    fits = all(is_taken(s, decoded[s.name]) for s in signals)
    expected = tuple(decoded[s.name] for s in signals) if fits else None
    assert codec_of(wire, message).unpack(payload) == expected


@every_message
def test_least_and_greatest_values_travel_and_one_beyond_is_refused(
    wire: Wire, message: Message
) -> None:
    codec, quiet = codec_of(wire, message), quiet_values(message)
    for signal in payload_of(message):
        for bound, outward in ((signal.minimum, -1), (signal.maximum, +1)):
            if is_taken(signal, bound):
                values = {**quiet, signal.name: bound}
                payload = pack(codec, values)
                assert payload == oracle(message, values)
                assert getattr(codec.unpack(payload), signal.name) == bound

            beyond = (
                next_float32(bound, outward)
                if signal.is_float
                else bound + outward * signal.conversion.scale
            )
            with pytest.raises(EncodeError, match=rf"^{message.name}\.{signal.name}: .*{bound}"):
                pack(codec, {**quiet, signal.name: beyond})


@every_message
def test_a_forged_value_beyond_its_range_is_refused(wire: Wire, message: Message) -> None:
    codec = codec_of(wire, message)
    names = [signal.name for signal in payload_of(message)]
    quiet = message.decode(oracle(message, quiet_values(message)), scaling=False)
    quiet = {name: quiet[name] for name in names}
    assert codec.unpack(oracle(message, quiet, raw=True)) is not None
    for signal in payload_of(message):
        low, high = raw_bounds(signal)
        least, greatest = raw_limits(signal)
        forged = {
            *((next_float32(low, -1), next_float32(high, +1)) if signal.is_float else ()),
            *((low - 1, high + 1) if not signal.is_float else ()),
            *(least, greatest),
        }
        for raw in forged:
            if least <= raw <= greatest and not low <= raw <= high:
                payload = oracle(message, {**quiet, signal.name: raw}, raw=True)
                assert codec.unpack(payload) is None, (signal.name, raw)


@every_message
def test_values_of_an_enumeration_travel_if_they_have_a_name(wire: Wire, message: Message) -> None:
    """The range is reserved wider than the table: a new value is no new layout, nor is it known."""
    codec, quiet = codec_of(wire, message), quiet_values(message)
    for signal in payload_of(message):
        known = known_of(signal)
        for value in range(signal.minimum, signal.maximum + 1) if known else ():
            forged = oracle(message, {**quiet, signal.name: value}, raw=True)
            if value in known:
                assert getattr(codec.unpack(forged), signal.name) == value
                assert pack(codec, {**quiet, signal.name: value}) == forged
            else:
                assert codec.unpack(forged) is None
                with pytest.raises(EncodeError, match=rf"{signal.name}: {value} has no name"):
                    pack(codec, {**quiet, signal.name: value})


@every_message
def test_no_numbers_are_refused_both_ways(wire: Wire, message: Message) -> None:
    codec, quiet = codec_of(wire, message), quiet_values(message)
    for signal in payload_of(message):
        for value in NO_NUMBERS:
            with pytest.raises(EncodeError, match=rf"^{message.name}\.{signal.name}: "):
                pack(codec, {**quiet, signal.name: value})
            if signal.is_float:
                forged = bytearray(oracle(message, quiet))
                struct.pack_into("<f", forged, signal.start // 8, value)
                assert codec.unpack(bytes(forged)) is None


@every_message
def test_signalling_and_negative_nans_are_refused_too(wire: Wire, message: Message) -> None:
    codec = codec_of(wire, message)
    for signal in payload_of(message):
        if signal.is_float:
            for bits in (0x7F800001, 0xFFC00000, 0xFFFFFFFF):
                forged = bytearray(oracle(message, quiet_values(message)))
                struct.pack_into("<I", forged, signal.start // 8, bits)
                assert codec.unpack(bytes(forged)) is None


@every_message
def test_only_whole_numbers_fit_integer_signals(wire: Wire, message: Message) -> None:
    codec, quiet = codec_of(wire, message), quiet_values(message)
    for signal in payload_of(message):
        if signal.is_float or signal.conversion.scale != 1:
            continue
        for value in (quiet[signal.name] + 0.5, float(quiet[signal.name])):
            with pytest.raises(
                EncodeError, match=rf"^{message.name}\.{signal.name}: .* whole number$"
            ):
                pack(codec, {**quiet, signal.name: value})


def test_half_a_step_of_a_scaled_signal_rounds_as_in_cantools(wire: Wire) -> None:
    scaled = [
        (message, signal)
        for message in MESSAGES
        for signal in payload_of(message)
        if not signal.is_float and signal.conversion.scale != 1
    ]
    assert [signal.name for _, signal in scaled] == ["force"]
    for message, signal in scaled:
        low, high = raw_bounds(signal)
        scale, offset = signal.conversion.scale, signal.conversion.offset
        for raw in range(int(low), int(high)):
            for step in (0.25, 0.5, 0.75, 1.0):
                values = {**quiet_values(message), signal.name: (raw + step) * scale + offset}
                payload = pack(codec_of(wire, message), values)
                assert payload == oracle(message, values)
                unpacked = getattr(codec_of(wire, message).unpack(payload), signal.name)
                assert abs(unpacked - values[signal.name]) <= scale / 2


@every_message
def test_every_other_length_is_refused(wire: Wire, message: Message) -> None:
    decoder, values = Decoder(codec_of(wire, message)), quiet_values(message)
    frame = Sender(codec_of(wire, message)).frame(*values.values())
    assert len(frame.data) == message.length
    assert decoder.decode(frame) == tuple(values.values())
    for length in FD_LENGTHS - {message.length}:
        other = (frame.data + bytes(64))[:length]
        assert decoder.decode(Frame(frame.id, other)) is Refusal.LENGTH
    for length in (message.length - 1, message.length + 1):
        if length not in FD_LENGTHS:
            with pytest.raises(FrameError, match=f"{length} bytes"):
                Frame(frame.id, (frame.data + b"\0")[:length])


@every_message
def test_a_buffer_too_short_or_a_value_too_few_is_our_bug(wire: Wire, message: Message) -> None:
    codec, values = codec_of(wire, message), quiet_values(message)
    with pytest.raises(EncodeError, match=message.name):
        codec.pack_into(bytearray(message.length - 1), *values.values())
    with pytest.raises(TypeError):
        codec.pack_into(bytearray(message.length))


def test_a_classic_frame_is_refused_unless_it_stops_the_arm(wire: Wire) -> None:
    short = [message for message in MESSAGES if message.length <= 8]
    assert {message.name for message in short} >= {"ESTOP", "NMT", "GRIPPER", "DAC_1"}
    for message in short:
        values = tuple(quiet_values(message).values())
        good = Sender(codec_of(wire, message)).frame(*values)
        decoder = Decoder(codec_of(wire, message))
        as_classic = decoder.decode(Frame(good.id, good.data, fd=False))
        assert as_classic == (values if message.name == "ESTOP" else Refusal.KIND)
        assert decoder.decode(good) == values
