"""End-to-end protection: what the header holds, and every kind of frame that is refused."""

import binascii
from collections import Counter
from typing import Any

import pytest
from e2e.p05 import e2e_p05_protect
from support.wire_messages import every_protected_message, frames_of, some_values

from rfms_can.errors import EncodeError
from rfms_can.wire.codec import MessageCodec, database_hash, load_database
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.protection import (
    COUNTER_RESTART,
    COUNTER_WINDOW,
    Decoder,
    Receiver,
    Refusal,
)
from rfms_can.wire.records import Dac, Heartbeat, JointError, Measure, Rows, Sync


def crc_of(data: bytes, data_id: int) -> int:
    """CRC-16/IBM-3740 of counter, payload and data ID, low byte first; not the library's code."""
    return binascii.crc_hqx(data[2:] + data_id.to_bytes(2, "little"), 0xFFFF)


def forge(codec: MessageCodec[Any], frame: Frame, at: int, value: bytes) -> Frame:
    """The frame with other bytes at ``at``, and a right CRC over them."""
    data = bytearray(frame.data)
    data[at : at + len(value)] = value
    assert codec.data_id is not None
    e2e_p05_protect(data, codec.data_id, increment_counter=False)
    return Frame(frame.id, bytes(data))


# the header


@pytest.mark.parametrize(
    ("length", "offset", "expected"),
    [(8, 0, "1cca000000000000"), (16, 8, "00000000000000002891000000000000")],
)
def test_profile_5_agrees_with_autosars_example(length: int, offset: int, expected: str) -> None:
    """Examples of profile 5 in AUTOSAR's E2E protocol specification: data ID 0x1234, zeros."""
    data = bytearray(length)
    e2e_p05_protect(data, 0x1234, offset=offset, increment_counter=False)
    assert data.hex() == expected
    if offset == 0:
        assert crc_of(bytes(data), 0x1234) == 0xCA1C


@every_protected_message
def test_header_is_the_crc_low_byte_first_then_the_counter_from_zero(wire: Wire, name: str) -> None:
    codec = wire.codecs[name]
    assert codec.data_id is not None
    for counter, frame in enumerate(frames_of(codec, 3)):
        assert frame.id == codec.id
        assert frame.fd
        assert frame.data[2] == counter
        assert int.from_bytes(frame.data[:2], "little") == crc_of(frame.data, codec.data_id)


def test_the_counter_wraps_and_starts_anew_after_a_reset(wire: Wire) -> None:
    sender = wire.sender(Sync)
    counters = [sender.frame(cycle, 4, 0, 0).data[2] for cycle in range(300)]
    assert counters == [cycle & 0xFF for cycle in range(300)]
    sender.reset()
    assert sender.frame(0, 4, 0, 0).data[2] == 0


def test_a_refused_value_counts_nothing_and_leaves_nothing_behind(wire: Wire) -> None:
    sender, untroubled = wire.sender(JointError, 3), wire.sender(JointError, 3)
    assert sender.frame(0.1, 0.2, 0.3, 1) == untroubled.frame(0.1, 0.2, 0.3, 1)
    for values in ((float("nan"), 9.0, 9.0, 9), (1.0, 1001.0, 9.0, 9), (1.0, 9.0, 9.0, 0.5)):
        with pytest.raises(EncodeError, match=r"^ERROR_3\."):
            sender.frame(*values)
    assert sender.frame(0.4, 0.5, 0.6, 2) == untroubled.frame(0.4, 0.5, 0.6, 2)


# the counter


def test_each_frame_is_taken_once(wire: Wire) -> None:
    receiver, frames = wire.receiver(Dac, 2), frames_of(wire.codec(Dac, 2), 3)
    taken = [receiver.take(frame) for frame in (frames[0], frames[0], frames[1], frames[1])]
    assert [values is not None for values in taken] == [True, False, True, False]
    assert receiver.refused == {Refusal.DUPLICATE: 2}
    assert receiver.lost == 0


def test_a_gap_is_taken_and_counted(wire: Wire) -> None:
    receiver, frames = wire.receiver(Dac, 2), frames_of(wire.codec(Dac, 2), 200)
    for index, lost in ((0, 0), (1, 0), (3, 1), (10, 7), (26, 22)):
        assert receiver.take(frames[index]) is not None
        assert receiver.lost == lost
    assert not receiver.refused


@pytest.mark.parametrize("back", [1, 2, 100, 128])
def test_an_older_frame_is_refused(wire: Wire, back: int) -> None:
    receiver, frames = wire.receiver(Dac, 2), frames_of(wire.codec(Dac, 2), 202)
    assert receiver.take(frames[199]) is not None
    assert receiver.take(frames[200]) is not None
    assert receiver.take(frames[200 - back]) is None
    assert receiver.refused == {Refusal.ORDER: 1}
    assert receiver.take(frames[201]) is not None
    assert receiver.lost == 0


def test_the_rule_of_the_counters_is_the_contracts() -> None:
    attributes = load_database().dbc.attributes
    assert attributes["RfmsCounterWindow"].value == COUNTER_WINDOW == 16
    assert attributes["RfmsCounterRestart"].value == COUNTER_RESTART == 3


def test_the_contract_tells_the_hash_of_its_own_layout() -> None:
    """A node in another language has it from the DBC alone."""
    assert load_database().dbc.attributes["RfmsDbcHash"].value == database_hash()


@pytest.mark.parametrize("step", range(256))
def test_a_step_of_the_counter_is_taken_up_to_the_window(wire: Wire, step: int) -> None:
    """Every step there is, from a counter that wraps on the way."""
    frames = frames_of(wire.codec(Dac, 2), 500)
    receiver = wire.receiver(Dac, 2)
    assert receiver.take(frames[239]) is not None
    assert receiver.take(frames[240]) is not None
    taken = receiver.take(frames[240 + step]) is not None
    assert taken == (1 <= step <= COUNTER_WINDOW)
    assert receiver.lost == (step - 1 if taken else 0)


def test_a_receiver_that_was_deaf_hears_its_sender_again_at_the_third_frame(wire: Wire) -> None:
    receiver, frames = wire.receiver(Dac, 2), frames_of(wire.codec(Dac, 2), 200)
    assert receiver.take(frames[0]) is not None
    assert receiver.take(frames[1]) is not None
    taken = [receiver.take(frame) is not None for frame in frames[100:105]]
    assert taken == [False, False, True, True, True]
    assert receiver.leaps == 1
    assert receiver.refused == {Refusal.ORDER: 2}


def test_strays_count_only_in_a_row_and_in_step(wire: Wire) -> None:
    """Frames of an old recording among those of a sender that is well: never taken."""
    receiver, frames = wire.receiver(Dac, 2), frames_of(wire.codec(Dac, 2), 200)
    receiver.take(frames[0])
    for index in range(1, 60):
        assert receiver.take(frames[index]) is not None
        assert receiver.take(frames[99 + index]) is None
    for stray in (100, 100, 130, 160, 100):  # the same, or too far apart
        assert receiver.take(frames[stray]) is None
    assert receiver.leaps == 0


def test_each_leap_makes_the_next_one_harder(wire: Wire) -> None:
    """A stream that leaps to and fro is taken less and less, until START or RESET."""
    receiver, frames = wire.receiver(Dac, 2), frames_of(wire.codec(Dac, 2), 240)
    receiver.take(frames[0])
    receiver.take(frames[1])
    needed = []
    for begin in (100, 0, 100):
        taken = [receiver.take(frame) is not None for frame in frames[begin : begin + 30]]
        needed.append(taken.index(True) + 1)
    assert needed == [COUNTER_RESTART, 2 * COUNTER_RESTART, 4 * COUNTER_RESTART]
    receiver.reset()
    assert receiver.take(frames[5]) is not None
    assert receiver.take(frames[6]) is not None
    assert [receiver.take(frame) is not None for frame in frames[100:103]] == [False, False, True]


def test_a_heartbeat_of_another_start_is_taken_at_once(wire: Wire) -> None:
    """The boot id says that its sender counts from 0 again."""
    sender, receiver = wire.sender(Heartbeat, 3), wire.receiver(Heartbeat, 3)

    def beat(boot_id: int) -> Frame:
        return sender.frame(1, 0, 0, boot_id, 0, 0, 0, 0)

    for _ in range(40):
        assert receiver.take(beat(7)) is not None
    sender.reset()
    assert receiver.take(beat(7)) is None  # the same start: an old frame
    again = beat(8)
    assert receiver.take(again) is not None
    assert receiver.take(again) is None
    assert receiver.refused == {Refusal.ORDER: 1, Refusal.DUPLICATE: 1}


def test_a_thousand_frames_wrap_without_a_loss(wire: Wire) -> None:
    receiver = wire.receiver(Dac, 2)
    assert all(receiver.take(frame) for frame in frames_of(wire.codec(Dac, 2), 1000))
    assert receiver.lost == 0
    assert not receiver.refused


def test_the_first_frame_counts_from_anywhere_also_after_a_reset(wire: Wire) -> None:
    receiver, frames = wire.receiver(Dac, 2), frames_of(wire.codec(Dac, 2), 200)
    assert receiver.take(frames[76]) is not None
    assert receiver.take(frames[77]) is not None
    assert receiver.take(frames[70]) is None
    receiver.reset()
    assert receiver.take(frames[0]) is not None  # the sender restarted
    assert receiver.take(frames[1]) is not None
    assert receiver.lost == 0


@pytest.mark.parametrize("second", [1, 100, 199])
def test_a_stray_in_the_first_place_does_not_shut_its_sender_out(wire: Wire, second: int) -> None:
    """The first frame may have been under way since before: the second counts from anywhere too."""
    receiver, frames = wire.receiver(Dac, 2), frames_of(wire.codec(Dac, 2), 202)
    assert receiver.take(frames[150]) is not None
    assert receiver.take(frames[150]) is None  # a duplicate is one all the same
    assert receiver.take(frames[second]) is not None
    assert receiver.take(frames[second + 1]) is not None
    assert receiver.take(frames[second]) is None
    assert receiver.leaps == 0


# whole or not at all


def test_a_refused_frame_changes_nothing(wire: Wire) -> None:
    codec = wire.codec(Measure, 4)
    troubled, calm = wire.receiver(Measure, 4), wire.receiver(Measure, 4)
    frames = frames_of(codec, 4)
    for receiver in (troubled, calm):
        assert receiver.take(frames[0]) is not None
    assert troubled.take(Frame(codec.id, bytes(codec.length))) is None
    assert troubled.take(Frame(codec.id, frames[1].data[:8])) is None
    assert troubled.take(Frame(codec.id, frames[1].data[:8], fd=False)) is None
    assert troubled.take(Frame(codec.id, frames[1].data[:-1] + b"\xff")) is None
    assert troubled.take(frames[0]) is None
    for frame in frames[1:]:
        assert troubled.take(frame) == calm.take(frame)
    assert troubled.lost == calm.lost == 0
    assert not calm.refused
    assert troubled.refused == {
        Refusal.CRC: 2,
        Refusal.LENGTH: 1,
        Refusal.KIND: 1,
        Refusal.DUPLICATE: 1,
    }


def test_a_right_crc_does_not_excuse_a_value_out_of_range(wire: Wire) -> None:
    codec = wire.codec(Rows, 5)
    receiver, frames = wire.receiver(Rows, 5), frames_of(codec, 2)
    infinite = forge(codec, frames[0], 3, b"\x00\x00\x80\x7f")
    no_number = forge(codec, frames[0], 3, b"\x00\x00\xc0\x7f")
    unknown_law = forge(codec, frames[0], 56, b"\x02")
    for frame in (infinite, no_number, unknown_law):
        assert receiver.take(frame) is None
    assert receiver.refused == {Refusal.RANGE: 3}
    assert receiver.take(frames[0]) is not None  # its counter was not used up


def test_receivers_share_decoding_but_not_their_counters(wire: Wire) -> None:
    refused: Counter[Refusal] = Counter()
    first, second = (wire.receiver(Sync, refused=refused) for _ in range(2))
    assert first.decoder is second.decoder
    frames = frames_of(wire.codec(Sync), 2)
    assert first.take(frames[0]) is second.take(frames[0])
    assert first.take(frames[0]) is None
    assert second.take(frames[1]) is not None
    assert refused == {Refusal.DUPLICATE: 1}
    assert first.refused is second.refused is refused


def test_a_receiver_of_ones_own_takes_what_was_sent(wire: Wire) -> None:
    codec = wire.codec(Measure, 1)
    receiver = Receiver(Decoder(codec))
    values = receiver.take(frames_of(codec, 1)[0])
    assert isinstance(values, Measure)
    assert values == tuple(some_values(codec))
