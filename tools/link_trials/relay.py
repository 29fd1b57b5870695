"""A TCP relay: connections through it can be cut, and refused until it is mended."""

import contextlib
import socket
import threading
from typing import Final

HOST: Final = "127.0.0.1"
CHUNK: Final = 65_536


def free_ports(number: int) -> int:
    """The first of so many free ports in a row."""
    while True:
        with socket.socket() as first:
            first.bind((HOST, 0))
            port = int(first.getsockname()[1])
        with contextlib.suppress(OSError, OverflowError), contextlib.ExitStack() as stack:
            for place in range(number):
                stack.enter_context(socket.socket()).bind((HOST, port + place))
            return port


class Relay:
    """Relays ports to the ports of a server; threads that end with the process.

    Args:
        port: the first port to listen on.
        target: the server's first port.
        number: of ports in a row.
    """

    def __init__(self, port: int, target: int, number: int) -> None:
        self._cut = False
        self._open: set[socket.socket] = set()
        for place in range(number):
            listener = socket.create_server((HOST, port + place))
            self._start(self._accept, listener, target + place)

    def _start(self, body: object, *arguments: object) -> None:
        threading.Thread(target=body, args=arguments, daemon=True).start()  # type: ignore[arg-type]

    def cut(self) -> None:
        """End all connections, and refuse new ones."""
        self._cut = True
        for one in list(self._open):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def mend(self) -> None:
        """Take connections again."""
        self._cut = False

    def _accept(self, listener: socket.socket, target: int) -> None:
        while True:
            client, _ = listener.accept()
            if self._cut:
                client.close()
                continue
            try:
                server = socket.create_connection((HOST, target), timeout=2.0)
            except OSError:
                client.close()
                continue
            server.settimeout(None)
            self._open |= {client, server}
            self._start(self._pump, client, server)
            self._start(self._pump, server, client)

    def _pump(self, source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(CHUNK):
                sink.sendall(data)
        for one in (source, sink):
            self._open.discard(one)
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
