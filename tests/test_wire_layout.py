"""The compiler behind the codec: any layout it takes it moves right, the rest it refuses."""

from collections import namedtuple
from pathlib import Path
from typing import Any

import cantools
import pytest
from cantools.database.can import Message
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.errors import DbcError, EncodeError
from rfms_can.wire.codec import compile_message, database_hash, database_path, load_database
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Force

Bits = tuple[int, int, bool]  # gap before the signal, length, signed

any_layout = st.lists(
    st.tuples(st.integers(0, 11), st.integers(1, 33), st.booleans()), min_size=1, max_size=10
)


def message_of(*signals: str, length: int = 64, attributes: str = "") -> Message:
    """The one message of a small DBC."""
    text = [
        'VERSION ""\n\nBU_: A B\n',
        f"BO_ 1 M: {length} A",
        *(f" SG_ {signal} B" for signal in signals),
        '\nBA_DEF_ BO_ "RfmsE2EDataId" INT 0 65535;\nBA_DEF_DEF_ "RfmsE2EDataId" 0;',
        attributes,
    ]
    return cantools.database.load_string("\n".join(text) + "\n", "dbc").messages[0]


def compile_all(message: Message, *names: str) -> Any:
    return compile_message(message, namedtuple("M", names))


def placed(bits: list[Bits]) -> list[tuple[int, int, bool]]:
    """Start, length and sign of each signal."""
    starts, position = [], 0
    for gap, length, signed in bits:
        starts.append((position + gap, length, signed))
        position += gap + length
    return starts


@given(bits=any_layout, data=st.data())
def test_any_layout_of_integers_moves_as_in_cantools(bits: list[Bits], data: st.DataObject) -> None:
    texts, values = [], {}
    for number, (start, length, signed) in enumerate(placed(bits)):
        low = -(1 << length - 1) if signed else 0
        high = low + (1 << length) - 1
        sign = "-" if signed else "+"
        texts.append(f's{number} : {start}|{length}@1{sign} (1,0) [{low}|{high}] ""')
        values[f"s{number}"] = data.draw(st.integers(low, high))
    message = message_of(*texts)
    codec = compile_all(message, *values)
    buffer = bytearray(b"\xff" * 64)
    codec.pack_into(buffer, *values.values())
    assert bytes(buffer) == message.encode(values)
    assert codec.unpack(bytes(buffer)) == tuple(values.values())


@given(raw=st.integers(-(1 << 11), (1 << 11) - 1))
def test_scale_and_offset_move_as_in_cantools(raw: int) -> None:
    message = message_of('x : 3|12@1- (0.125,10) [-246|265.875] "m"', 'y : 15|1@1+ (1,0) [0|1] ""')
    codec = compile_all(message, "x", "y")
    values = {"x": raw * 0.125 + 10, "y": 1}
    buffer = bytearray(64)
    codec.pack_into(buffer, *values.values())
    assert bytes(buffer) == message.encode(values)
    assert codec.unpack(bytes(buffer)) == tuple(values.values())


def test_floats_and_bytes_behind_bits_move_as_in_cantools() -> None:
    message = message_of(
        'flag : 0|1@1+ (1,0) [0|1] ""',
        'torque : 8|32@1- (1,0) [-8|8] "Nm"',
        'code : 44|12@1- (1,0) [-2048|2047] ""',
        'count : 56|32@1+ (1,0) [0|4294967295] ""',
        attributes="SIG_VALTYPE_ 1 torque : 1;",
    )
    values = {"flag": 1, "torque": -1.25, "code": -2048, "count": 0xDEADBEEF}
    codec, buffer = compile_all(message, *values), bytearray(b"\xff" * 64)
    codec.pack_into(buffer, *values.values())
    assert bytes(buffer) == message.encode(values)
    assert codec.unpack(bytes(buffer)) == tuple(values.values())


@pytest.mark.parametrize("first", ['flag : 0|1@1+ (1,0) [0|1] ""', 'flag : 0|8@1+ (1,0) [0|1] ""'])
def test_a_signal_is_checked_wherever_it_stands(first: str) -> None:
    with pytest.raises(DbcError, match=r"M\.x: 3 bits cannot hold its range"):
        compile_all(message_of(first, 'x : 12|3@1+ (1,0) [0|8] ""'), "flag", "x")
    with pytest.raises(DbcError, match=r"M\.x: 3 bits cannot hold its range"):
        compile_all(
            message_of(first, 'y : 8|2@1+ (1,0) [0|3] ""', 'x : 10|3@1+ (1,0) [0|8] ""'),
            *("flag", "y", "x"),
        )


def test_names_of_the_generated_text_cannot_be_hidden() -> None:
    names = ("buffer", "data", "layout", "new", "record", "refuse", "word0")
    message = message_of(
        *(f'{name} : {12 * n}|12@1+ (1,0) [0|9] ""' for n, name in enumerate(names))
    )
    codec, buffer = compile_all(message, *names), bytearray(64)
    codec.pack_into(buffer, *range(1, 8))
    assert codec.unpack(bytes(buffer)) == (1, 2, 3, 4, 5, 6, 7)
    with pytest.raises(EncodeError, match=r"^M\.layout: 10 does not fit 0\.\.9$"):
        codec.pack_into(buffer, 1, 2, 10, 4, 5, 6, 7)


@pytest.mark.parametrize(
    ("signal", "complaint"),
    [
        ('x : 7|16@0+ (1,0) [0|1] ""', "little-endian"),
        ('x : 0|12@1+ (1,0) [0|4096] ""', "12 bits cannot hold its range"),
        ('x : 0|12@1- (1,0) [-2049|0] ""', "12 bits cannot hold its range"),
        ('x : 0|8@1+ (0.5,0) [0|128] ""', "8 bits cannot hold its range"),
    ],
)
def test_integers_that_would_be_moved_wrongly_are_refused(signal: str, complaint: str) -> None:
    with pytest.raises(DbcError, match=complaint):
        compile_all(message_of(signal), "x")


@pytest.mark.parametrize(
    ("signal", "bits", "complaint"),
    [
        ('x : 0|64@1- (1,0) [-1|1] ""', 2, "32 bits"),
        ('x : 4|32@1- (1,0) [-1|1] ""', 1, "begin a byte"),
        ('x : 0|32@1- (2,0) [-1|1] ""', 1, "scale 1"),
        ('x : 0|32@1- (1,0) [-0.1|0.1] ""', 1, "not float32 numbers"),
    ],
)
def test_floats_that_would_be_moved_wrongly_are_refused(
    signal: str, bits: int, complaint: str
) -> None:
    with pytest.raises(DbcError, match=complaint):
        compile_all(message_of(signal, attributes=f"SIG_VALTYPE_ 1 x : {bits};"), "x")


def test_a_signal_without_a_range_is_refused() -> None:
    with pytest.raises(DbcError, match=r"signal x has no range"):
        compile_all(message_of('x : 0|8@1+ (1,0) [0|0] ""'), "x")


def test_record_and_message_must_agree_on_names_and_order() -> None:
    message = message_of('x : 0|8@1+ (1,0) [0|1] ""', 'y : 8|8@1+ (1,0) [0|1] ""')
    with pytest.raises(DbcError, match=r"M: the DBC has signals x, y, but M has y, x"):
        compile_all(message, "y", "x")


def test_a_lost_data_id_does_not_switch_protection_off() -> None:
    header = ('e2e_crc : 0|16@1+ (1,0) [0|65535] ""', 'e2e_counter : 16|8@1+ (1,0) [0|255] ""')
    signal, data_id = 'x : 24|8@1+ (1,0) [0|1] ""', 'BA_ "RfmsE2EDataId" BO_ 1 7;'
    assert compile_all(message_of(*header, signal, attributes=data_id), "x").data_id == 7
    assert compile_all(message_of(signal), "x").data_id is None
    for half in (
        message_of(*header, signal),
        message_of(signal, attributes=data_id),
        message_of(header[0], signal, attributes=data_id),
    ):
        with pytest.raises(DbcError, match="go together"):
            compile_all(half, "x")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "not a database",
        'BO_ 1 M: 8 A\n SG_ x : 60|8@1+ (1,0) [0|1] "" B\n',
        'BO_ 1 M: 8 A\n SG_ x : 0|8@1+ (1,0) [0|1] "" B\n SG_ y : 7|8@1+ (1,0) [0|1] "" B\n',
    ],
    ids=["empty", "no DBC", "signal outside", "signals overlap"],
)
def test_a_file_that_is_no_usable_dbc_is_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "other.dbc"
    path.write_text(text)
    with pytest.raises(DbcError, match=r"other\.dbc"):
        load_database(path)


def test_a_dbc_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(DbcError, match=r"missing\.dbc"):
        Wire(tmp_path / "missing.dbc")


def test_a_dbc_with_one_message_less_or_more_is_refused(tmp_path: Path) -> None:
    blocks = database_path().read_text().split("\n\n")
    less = tmp_path / "less.dbc"
    force = next(block for block in blocks if block.startswith("BO_ 272 FORCE:"))
    kept = "\n\n".join(block for block in blocks if block is not force)
    less.write_text("\n".join(line for line in kept.split("\n") if " 272 " not in line))
    with pytest.raises(DbcError, match="no message FORCE"):
        Wire(less).sender(Force)

    more = tmp_path / "more.dbc"
    more.write_text("\n\n".join([*blocks[:4], force.replace("272 FORCE", "9 OTHER"), *blocks[4:]]))
    with pytest.raises(DbcError, match="messages without a record: OTHER"):
        Wire(more)


def test_the_hash_is_that_of_the_layout(tmp_path: Path) -> None:
    """Units and ranges are in it; line ends, comments and new values of an enumeration are not.

    With these a node made before understands all that it has a name for.
    """
    text = database_path().read_bytes()
    same = {
        "line ends": text.replace(b"\n", b"\r\n"),
        "a comment": text.replace(b"Start of a control cycle", b"A control cycle begins", 1),
        "a fault": text.replace(b' "EMERGENCY_STOP"', b' "EMERGENCY_STOP" 39 "MORE"'),
        "a law": text.replace(b' "WEIGHTED"', b' "WEIGHTED" 15 "MORE"'),
        "a parameter": text.replace(b'255 "COMMIT"', b'100 "MORE" 255 "COMMIT"'),
    }
    other = {
        "a unit": text.replace(b'"rad"', b'"deg"', 1),
        "a range": text.replace(b"[-2|2]", b"[-3|3]", 1),
        "an identifier": text.replace(b"BO_ 641 DAC_1", b"BO_ 640 DAC_1"),
        "a name": text.replace(b"row_set", b"set_row"),
        "a data ID": text.replace(b'"RfmsE2EDataId" BO_ 128 21120', b'"RfmsE2EDataId" BO_ 128 5'),
    }
    for name, variant in (same | other).items():
        assert variant != text, name
        path = tmp_path / f"{name}.dbc"
        path.write_bytes(variant)
        assert (database_hash(path) == database_hash()) == (name in same), name
