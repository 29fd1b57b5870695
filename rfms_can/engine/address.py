"""Addresses of a Dask scheduler that may be connected to.

A Dask scheduler runs any code that reaches its port, and so do its workers. So every connection
must either stay on this machine or be encrypted and authenticated both ways.
"""

import ipaddress
from contextlib import suppress
from typing import Final
from urllib.parse import urlsplit

from rfms_can.errors import EngineError

WHY: Final = "a Dask scheduler runs any code that reaches its port"


def is_loopback(address: str) -> bool:
    """Whether a host is this machine, and cannot be reached from another one."""
    host = urlsplit(address).hostname or ""
    with suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"


def checked(address: str) -> str:
    """An address that may be connected to: of this machine, or with TLS.

    Raises:
        EngineError: it may not, or is no address.
    """
    parts = urlsplit(address)
    try:
        port = parts.port
    except ValueError:
        port = None
    if parts.scheme not in ("tcp", "tls") or not parts.hostname or port is None:
        raise EngineError(f"cluster {address!r}: give tcp://127.0.0.1:PORT or tls://HOST:PORT")
    if parts.scheme == "tcp" and not is_loopback(address):
        raise EngineError(
            f"cluster {address}: {WHY}, so tcp:// is for loopback addresses: give "
            f"tls://{parts.netloc} with certificates (docs/campaigns.md)"
        )
    return address
