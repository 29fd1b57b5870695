"""Bus URLs: what they name, and what the refusals say."""

import re

import can
import pytest

from rfms_can.bus.driver import PythonCanPort, open_port
from rfms_can.bus.url import GRAMMAR, HUB, OWN, SIM, SOCKETCAN, parse_bus_url
from rfms_can.errors import BusError
from rfms_can.tables import complete
from rfms_can.wire.frame import Frame

NOTHING_HEARD: frozenset[int] = frozenset()
TAKEN = complete({SIM: "sim", HUB: "hub:bench-1", SOCKETCAN: "socketcan:vcan0"}, OWN)
"""A URL of each of our own buses."""
ABSENT = complete(
    {
        SIM: ("sim", "rfms hub NAME"),
        HUB: ("hub:nobody-runs-this", "rfms hub nobody-runs-this"),
        SOCKETCAN: ("socketcan:rfmsnone0", "ip link add rfmsnone0"),
    },
    OWN,
)
"""A URL that names none, and the way out of the refusal."""


def test_the_grammar_names_every_bus_of_our_own() -> None:
    assert [word for word in OWN if word not in re.split(r"\W+", GRAMMAR)] == []


@pytest.mark.parametrize(
    ("text", "interface", "channel", "options"),
    [
        *((text, word, text.partition(":")[2], {}) for word, text in TAKEN.items()),
        ("udp_multicast:239.0.0.1", "udp_multicast", "239.0.0.1", {}),
        ("virtual:x?fd=false", "virtual", "x", {"fd": False}),
        ("slcan:/dev/ttyACM0@115200", "slcan", "/dev/ttyACM0@115200", {}),
        (
            "kvaser:0?bitrate=1000000&data_bitrate=5000000&sjw=0.5&app=a%20b",
            "kvaser",
            "0",
            {"bitrate": 1_000_000, "data_bitrate": 5_000_000, "sjw": 0.5, "app": "a b"},
        ),
    ],
)
def test_a_url_names_interface_channel_and_options(
    text: str, interface: str, channel: str, options: dict[str, object]
) -> None:
    url = parse_bus_url(text)
    assert (url.interface, url.channel, url.options) == (interface, channel, options)
    assert str(url) == text


@pytest.mark.parametrize(
    "text",
    [
        "",
        "vcan0",
        "hub",
        "hub:",
        ":x",
        "sim:x",
        "Hub:x",
        "hub:x?fd=1",
        "socketcan:far/too/long",
        "kvaser:0?bitrate",
        "kvaser:0?a=1&a=2",
        "kvaser:0?interface=pcan",
    ],
)
def test_a_refusal_shows_the_grammar_and_an_example(text: str) -> None:
    with pytest.raises(BusError) as caught:
        parse_bus_url(text)
    assert repr(text) in str(caught.value)
    assert "socketcan:DEVICE" in str(caught.value)
    assert "kvaser:0?" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("url", "way_out"),
    [
        *ABSENT.values(),
        ("hub:no/name", "letters, digits"),
        ("nosuchinterface:0", "python-can's interfaces are"),
    ],
)
def test_a_bus_that_is_not_there_is_one_line_that_names_it_and_the_way_out(
    url: str, way_out: str
) -> None:
    with pytest.raises(BusError) as caught:
        open_port(url, NOTHING_HEARD)
    assert way_out in str(caught.value)
    assert "\n" not in str(caught.value)


def test_any_python_can_interface_is_a_port() -> None:
    kinds: list[str] = []
    first = open_port("virtual:rfms-url-test", frozenset({0x10}))
    second = open_port("virtual:rfms-url-test", frozenset({0x20}), on_foreign=kinds.append)
    assert isinstance(first, PythonCanPort)
    try:
        long, classic, unwanted = Frame(0x20, bytes(48)), Frame(0x20, b"a", False), Frame(0x30, b"")
        first.send([long, unwanted])
        sneak = can.Message(arbitration_id=0x20, is_extended_id=True)
        first._bus.send(sneak)
        first.send([classic])
        assert second.recv(0.0) == long
        assert second.recv(0.0) == classic
        assert second.recv(0.0) is None
        assert kinds == ["not 11-bit data"]
        assert first.statistics["sent"] == 3
        assert second.statistics["received"] == 2
        assert first.recv(0.0) is None, "own frames are not heard"
    finally:
        first.close()
        second.close()
