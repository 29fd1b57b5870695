"""Bus URLs: the address of a bus as one argument of a command line.

::

    bus         = "sim"                                the simulated bus, all nodes in one process
                | "hub:" NAME                          a hub on this machine (rfms hub NAME)
                | "socketcan:" DEVICE                  Linux: vcan0, can0, ...
                | INTERFACE ":" CHANNEL [ "?" OPTION { "&" OPTION } ]
    OPTION      = KEY "=" VALUE

``INTERFACE`` is any interface of python-can; ``CHANNEL`` and the options are its arguments:
``kvaser:0?bitrate=1000000&data_bitrate=5000000``, ``udp_multicast:239.0.0.1``, ``virtual:bench``.
Values that read as integers, decimals, ``true`` or ``false`` are passed as such. ``fd`` is true
unless the URL says otherwise.
"""

import re
from dataclasses import dataclass, field
from typing import Final
from urllib.parse import parse_qsl

from rfms_can.errors import BusError

SIM: Final = "sim"
HUB: Final = "hub"
SOCKETCAN: Final = "socketcan"
OWN: Final = (SIM, HUB, SOCKETCAN)
"""Buses of our own; any other word is an interface of python-can."""

GRAMMAR: Final = "sim | hub:NAME | socketcan:DEVICE | INTERFACE:CHANNEL[?KEY=VALUE&...]"
EXAMPLE: Final = "kvaser:0?bitrate=1000000&data_bitrate=5000000"

_INTERFACE: Final = re.compile(r"[a-z][a-z0-9_-]*")
_DEVICE: Final = re.compile(r"[^\s/:?&]{1,15}")  # IFNAMSIZ

Option = int | float | bool | str


@dataclass(frozen=True, slots=True)
class BusUrl:
    """A parsed bus URL.

    Attributes:
        text: as given.
        interface: one of ``OWN``, or a python-can interface.
        channel: hub name, device or channel; empty for ``sim``.
        options: further arguments of a python-can interface.
    """

    text: str
    interface: str
    channel: str = ""
    options: dict[str, Option] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.text


def parse_bus_url(text: str) -> BusUrl:
    """Parse a bus URL.

    Raises:
        BusError: it violates the grammar, which the message shows.
    """
    if text == SIM:
        return BusUrl(text, SIM)
    interface, colon, rest = text.partition(":")
    channel, question, query = rest.partition("?")
    if not colon or not channel:
        raise _refusal(text, "it names no channel" if interface else "it names no interface")
    if not _INTERFACE.fullmatch(interface) or interface == SIM:
        raise _refusal(text, f"{interface!r} is not an interface with a channel")
    if interface in OWN and question:
        raise _refusal(text, f"{interface} takes no options")
    if interface == SOCKETCAN and not _DEVICE.fullmatch(channel):
        raise _refusal(text, f"{channel!r} is not a network device name")
    return BusUrl(text, interface, channel, _options(text, query) if question else {})


def is_simulated(text: str) -> bool:
    """Whether no motor can hang on a bus: sim, a hub, or a virtual CAN interface.

    Raises:
        BusError: it violates the grammar.
    """
    url = parse_bus_url(text)
    virtual = url.interface == SOCKETCAN and url.channel.startswith("vcan")
    return url.interface in (SIM, HUB) or virtual


def _options(text: str, query: str) -> dict[str, Option]:
    try:
        pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=True)
    except ValueError as error:
        raise _refusal(text, f"options are KEY=VALUE joined by '&', not {query!r}") from error
    options: dict[str, Option] = {}
    for key, value in pairs:
        if not key.isidentifier() or key in options or key in ("interface", "channel"):
            raise _refusal(text, f"option {key!r} is not a name, or is given twice")
        options[key] = _option_value(value)
    return options


def _option_value(value: str) -> Option:
    if value.lower() in ("true", "false"):
        return value.lower() == "true"
    for number in (int, float):
        try:
            return number(value)
        except ValueError:
            continue
    return value


def _refusal(text: str, reason: str) -> BusError:
    return BusError(f"bus {text!r}: {reason}. A bus is {GRAMMAR}, e.g. {EXAMPLE}")
