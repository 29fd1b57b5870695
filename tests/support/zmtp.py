"""A peer of ZeroMQ made of a plain socket (ZMTP 3.0, RFC 23): it does what no library would."""

import socket
from pathlib import Path
from typing import Final

MORE: Final = b"\x03"
"""Flags of a long frame that is not the last of its message."""
_GREETING: Final = b"\xff" + bytes(8) + b"\x7f" + b"\x03\x00" + b"NULL".ljust(20, b"\0") + bytes(32)


class RawPeer:
    """A connected peer that has introduced itself.

    Args:
        where: path of a Unix socket, or TCP port of 127.0.0.1.
        kind: of its socket, e.g. DEALER.
    """

    def __init__(self, where: Path | int, kind: str) -> None:
        if isinstance(where, int):
            self.socket = socket.create_connection(("127.0.0.1", where))
        else:
            self.socket = socket.socket(socket.AF_UNIX)
            self.socket.connect(str(where))
        self.socket.sendall(_GREETING)
        self.socket.recv(64, socket.MSG_WAITALL)
        body = b"\x05READY\x0bSocket-Type" + len(kind).to_bytes(4, "big") + kind.encode()
        self.socket.sendall(b"\x04" + bytes((len(body),)) + body)

    def endless(self, at_most: int, part: int = 60_000) -> int:
        """Send parts of a message that does not end; bytes that went until it was cut.

        Args:
            at_most: bytes after which it gives up.
            part: bytes of each.
        """
        packet = MORE + part.to_bytes(8, "big") + bytes(part)
        sent = 0
        try:
            while sent < at_most:
                self.socket.sendall(packet)
                sent += part
        except OSError:
            pass
        return sent
