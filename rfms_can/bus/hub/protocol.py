"""Protocol of a hub and its clients on a Unix SOCK_SEQPACKET socket.

1. The client sends one ``Hello``, the hub answers with one ``Welcome`` (JSON). From then on the
   client receives the traffic: a frame it sends after its welcome reaches all clients that were
   welcomed before.
2. Every further packet, either way, is one frame or several, each a ``struct canfd_frame`` of 72
   bytes (``canfd_struct``). A client that cannot handle several requests one per packet.
"""

from typing import Final

import msgspec

from rfms_can.bus.canfd_struct import CANFD_BYTES

VERSION: Final = 1
MAX_FRAMES_PER_PACKET: Final = 64
MAX_PACKET_BYTES: Final = MAX_FRAMES_PER_PACKET * CANFD_BYTES
MAX_HELLO_BYTES: Final = 1 << 15


class Hello(msgspec.Struct, forbid_unknown_fields=True):
    """A client introduces itself.

    Attributes:
        client: its name in the hub's statistics.
        ids: identifiers to receive; None for every frame, extended and remote ones too.
        echo: whether to receive its own frames.
        batch: whether it accepts several frames in one packet.
        version: of this protocol.
    """

    client: str
    ids: list[int] | None = None
    echo: bool = False
    batch: bool = True
    version: int = VERSION


class Welcome(msgspec.Struct, forbid_unknown_fields=True):
    """The hub's answer.

    Attributes:
        nominal_bit_rate: of the emulated bus, bit/s.
        data_bit_rate: bit/s; None for a classic bus.
        refused: why the client is refused; empty if it is accepted.
    """

    nominal_bit_rate: int
    data_bit_rate: int | None
    refused: str = ""
