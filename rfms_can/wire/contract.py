"""The wire contract for nodes: typed records, enumerations, and their senders and receivers."""

from collections import Counter
from pathlib import Path
from typing import Any, Final, NamedTuple

from rfms_can.errors import DbcError
from rfms_can.wire.codec import (
    MessageCodec,
    Record,
    compile_message,
    database_hash,
    load_database,
)
from rfms_can.wire.protection import Decoder, HeartbeatReceiver, Receiver, Refusal, Sender
from rfms_can.wire.records import (
    Bias,
    Comply,
    Config,
    ConfigAck,
    Dac,
    Emcy,
    Estop,
    Force,
    Gripper,
    Heartbeat,
    JointAngles,
    JointError,
    Measure,
    Nmt,
    Position,
    Reference,
    Rows,
    Setpoint,
    Sync,
)

LAST_CYCLE: Final = 0xFFFF_FFFF
"""Largest number of a cycle that SYNC carries, after 25 days at 2 kHz: 0 comes after it."""
NO_SET: Final = 0
"""Row set number in SYNC before the first set; not used by any set."""

LAST_SET: Final = 255
"""Highest number of a set of rows; 1 comes after it."""

COMPLY_BELONGS: Final = 1
BIAS_BELONGS: Final = 2
JOINT_SETPOINT_BELONGS: Final = 4
KNOWN_EXTRAS: Final = COMPLY_BELONGS | BIAS_BELONGS | JOINT_SETPOINT_BELONGS
"""Bits of SETPOINT's ``extras``: which frames belong to it beside its poses."""

MESSAGES: Final[dict[type[NamedTuple], str]] = {
    Estop: "ESTOP",
    Nmt: "NMT",
    Sync: "SYNC",
    Emcy: "EMCY_{}",
    Measure: "MEASURE_{}",
    Force: "FORCE",
    Setpoint: "SETPOINT_{}",
    Comply: "COMPLY",
    JointAngles: "JOINT_SETPOINT_{}",
    Bias: "BIAS",
    Gripper: "GRIPPER",
    Reference: "REFERENCE_{}",
    JointError: "ERROR_{}",
    Dac: "DAC_{}",
    Position: "POSITION_{}",
    Rows: "ROWS_{}",
    Config: "CONFIG_{}",
    ConfigAck: "CONFIG_ACK_{}",
    Heartbeat: "HEARTBEAT_{}",
}
"""DBC message of each record; ``{}`` is the node (or, for SETPOINT, the pose: 1 or 2)."""

ESTOP_VALUES: Final = Estop(0x504F5453, 0xAFB0ABAC)


class Wire:
    """Compiled codecs of all messages; one for a process.

    Args:
        path: DBC to use instead of the package's own.

    Attributes:
        dbc_hash: 16-bit hash of the DBC, as SYNC and HEARTBEAT carry it.
        codecs: every compiled message by its name in the DBC.
    """

    def __init__(self, path: Path | None = None) -> None:
        database = load_database(path)
        self.dbc_hash = database_hash(path)
        self.codecs: dict[str, MessageCodec[Any]] = {}
        self._decoders: dict[str, Decoder[Any]] = {}
        for record, template in MESSAGES.items():
            prefix = template.removesuffix("{}")
            for message in database.messages:
                name = message.name
                matches = name[len(prefix) :].isdigit() if "{}" in template else name == prefix
                if name.startswith(prefix) and matches:
                    self.codecs[name] = compile_message(message, record)
        missing = {m.name for m in database.messages} - set(self.codecs)
        if missing:
            raise DbcError(f"messages without a record: {', '.join(sorted(missing))}")

    def codec(self, record: type[Record], node: int | None = None) -> MessageCodec[Record]:
        """The compiled message of a record; ``node`` where the message has one for each.

        Raises:
            DbcError: the DBC has no such message.
        """
        name = MESSAGES[record].format(node)
        if name not in self.codecs:
            raise DbcError(f"the DBC has no message {name} ({record.__name__} of node {node})")
        return self.codecs[name]

    def id(self, record: type[Record], node: int | None = None) -> int:
        """CAN identifier of a message."""
        return self.codec(record, node).id

    def sender(self, record: type[Record], node: int | None = None) -> Sender[Record]:
        """A new sender of a message, with a counter of its own."""
        return Sender(self.codec(record, node))

    def receiver(
        self,
        record: type[Record],
        node: int | None = None,
        refused: Counter[Refusal] | None = None,
    ) -> Receiver[Record]:
        """A new receiver of a message, with a counter of its own; decoding is shared."""
        codec = self.codec(record, node)
        decoder = self._decoders.setdefault(codec.name, Decoder(codec))
        if issubclass(record, Heartbeat):
            return HeartbeatReceiver(decoder, refused)
        return Receiver(decoder, refused)
