"""Addresses of a server: Unix sockets under its name, TCP only on request.

A NAME stands for three Unix sockets, ``requests``, ``status`` and ``emergency``, in a directory
only its owner can enter (``rendezvous.py``); ``tcp://ADDRESS:PORT`` for PORT and the two after it.
A fourth, ``operator``, is a Unix socket alone: what a person does at the server's machine.
"""

import ipaddress
import re
from pathlib import Path
from typing import Final, NamedTuple

from rfms_can.errors import LinkError
from rfms_can.link.rendezvous import Rendezvous, running_names

DEFAULT_NAME: Final = "rfms"
SOCKETS: Final = ("requests", "status", "emergency")
OPERATOR: Final = "operator"
LONGEST_PATH: Final = 107
"""Longest path of a Unix socket, bytes (``sun_path`` of unix(7), without the final zero)."""
LAST_PORT: Final = 65_533
"""The highest port with two after it."""

_TCP: Final = re.compile(r"tcp://(?P<host>[0-9.]+|\[[0-9A-Fa-f:.]+\]):(?P<port>[0-9]{1,5})")


class Endpoints(NamedTuple):
    """ZeroMQ's names of a server's three sockets."""

    requests: str
    status: str
    emergency: str


class TcpAddress(NamedTuple):
    """A numerical address and the first of three ports."""

    host: str
    port: int

    @property
    def loopback(self) -> bool:
        """Whether it is reachable from this machine only."""
        return ipaddress.ip_address(self.host).is_loopback

    @property
    def ipv6(self) -> bool:
        """Whether it is an IPv6 address."""
        return ":" in self.host

    @property
    def endpoints(self) -> Endpoints:
        """ZeroMQ's names."""
        host = f"[{self.host}]" if self.ipv6 else self.host
        return Endpoints(*(f"tcp://{host}:{self.port + place}" for place in range(len(SOCKETS))))


def rendezvous_of(name: str) -> Rendezvous:
    """The rendezvous directory of a server of this name."""
    return Rendezvous("server", name, LinkError)


def socket_paths(name: str) -> tuple[Path, ...]:
    """The paths of a server's Unix sockets, in the order of ``SOCKETS``; last the operator's.

    Raises:
        LinkError: an invalid name, or paths too long for Unix sockets.
    """
    directory = rendezvous_of(name).directory
    paths = tuple(directory / socket for socket in (*SOCKETS, OPERATOR))
    longest = max(len(str(path).encode()) for path in paths)
    if longest > LONGEST_PATH:
        raise LinkError(
            f"{directory} is too long for Unix sockets: {longest} bytes, {LONGEST_PATH} fit; "
            f"set XDG_RUNTIME_DIR to a shorter one"
        )
    return paths


def ipc_endpoints(name: str) -> Endpoints:
    """ZeroMQ's names of a server's Unix sockets."""
    return Endpoints(*(f"ipc://{path}" for path in socket_paths(name)[: len(SOCKETS)]))


def operator_endpoint(name: str) -> str:
    """ZeroMQ's name of the operator's socket of a running server.

    Raises:
        LinkError: no server of that name runs, or its directory is open to other users.
    """
    endpoints_of(_local(name))
    return f"ipc://{socket_paths(name)[-1]}"


def _local(name: str) -> str:
    if "://" in name:
        raise LinkError(
            f"{name}: the operator's socket is on the server's machine alone: give its NAME there"
        )
    return name


def tcp_address(text: str) -> TcpAddress:
    """The address in ``tcp://ADDRESS:PORT``.

    Raises:
        LinkError: invalid address; host names are not looked up.
    """
    match = _TCP.fullmatch(text)
    if match is None:
        raise LinkError(f"address {text!r}: a server's name, or tcp://127.0.0.1:PORT")
    return checked(match["host"].strip("[]"), int(match["port"]))


def checked(host: str, port: int) -> TcpAddress:
    """A validated TCP address.

    Raises:
        LinkError: the host is not a numerical address, or the port leaves no room for two more.
    """
    try:
        ipaddress.ip_address(host)
    except ValueError as error:
        raise LinkError(
            f"address {host!r} is not numerical, e.g. 127.0.0.1; host names are not looked up"
        ) from error
    if not 1 <= port <= LAST_PORT:
        raise LinkError(f"port {port} is not in 1..{LAST_PORT}; three in a row are used")
    return TcpAddress(host, port)


def endpoints_of(address: str, *, with_keys: bool = False) -> Endpoints:
    """Where a client connects to.

    Args:
        address: a server's NAME, or ``tcp://ADDRESS:PORT``.
        with_keys: whether the client has CURVE keys.

    Raises:
        LinkError: no server of that name runs, its directory is open to other users, the address
            is invalid, or it is on another machine and no keys are given.
    """
    if "://" in address:
        tcp = tcp_address(address)
        if not tcp.loopback and not with_keys:
            raise LinkError(f"{address} is not on this machine: give the keys of server and client")
        return tcp.endpoints
    place = rendezvous_of(address)
    if not place.alive:
        names = ", ".join(running_names(place.what)) or "none"
        raise LinkError(
            f"no server {address!r} is running (running: {names}); start one: "
            f"rfms serve --name {address}"
        )
    place.check_ours()
    return ipc_endpoints(address)
