"""Check 51: how long a node takes, on a bus whose time is real."""

from typing import Final

from rfms_can.conform.checks.ladder import operational
from rfms_can.conform.outcome import CheckSkipped
from rfms_can.conform.tester import Tester
from rfms_can.wire.codec import load_database

CYCLES: Final = 10_000
HOST_NS: Final = 300_000
"""What the tester's own host may add to an answer, ns."""
LATE_ALLOWED: Final = 0.001
"""Part of the answers that the tester's host may have kept for longer."""


def response_ns(name: str) -> int:
    """RfmsResponseTime of a message, ns."""
    attributes = load_database().get_message_by_name(name).dbc.attributes
    return int(attributes["RfmsResponseTime"].value) * 1000


def response(t: Tester) -> None:
    """ERROR after the later of MEASURE and the set-point, DAC after the sixth ERROR."""
    if t.line.virtual or not t.line.settle_ns:
        raise CheckSkipped("needs a CAN interface: elsewhere the host is measured, not the node")
    operational(t)
    late = dict.fromkeys(("ERROR", "DAC"), 0)
    longest = dict.fromkeys(late, 0)
    for _ in range(CYCLES):
        t.sync()
        t.measure()
        for name, speak in (("ERROR", t.setpoint), ("DAC", t.errors)):
            t.equal(len(speak().of(name)), 1, f"{name} frames")
            taken = t.heard_ns[name] - t.sent_ns
            longest[name] = max(longest[name], taken)
            late[name] += taken > response_ns(f"{name}_{t.joint}") + HOST_NS
    for name, count in late.items():
        if count > LATE_ALLOWED * CYCLES:
            told = f"{count} of {CYCLES} {name} late, the longest {longest[name] / 1000:.0f} us"
            t.fail(told, f"within {response_ns(f'{name}_{t.joint}') / 1000:.0f} us")
