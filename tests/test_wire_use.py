"""What travels is used: a message is sent and heard, a parameter is known to who needs it."""

import ast
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import pytest
from support.fleet import Fleet
from support.wire_messages import MESSAGES, kind_of, payload_of

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.field_node import Parameters
from rfms_can.joint_nodes.gripper import GripperNode
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.wire.codec import Record
from rfms_can.wire.configuration import (
    GRIPPER_PARAMETERS,
    PARAMETERS,
    Clock,
    configuration_hash,
)
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import DBC_NAMES, GRIPPER, JOINTS, MASTER, PLANT
from rfms_can.wire.protection import Receiver, Sender
from rfms_can.wire.records import Config
from rfms_can.wire.vocabulary import ConfigStatus, Parameter

# --- messages -----------------------------------------------------------------------------------

OURS: Final = {DBC_NAMES[n] for n in (*JOINTS, GRIPPER, MASTER, PLANT)}
"""The nodes of this package; boards and a force sensor of their own are other people's."""

POSITIONS: Final = dict.fromkeys(
    (f"POSITION_{n}" for n in (*JOINTS, GRIPPER)), "no joint node drives a board of its kind yet"
)
HALTS: Final = "the master halts the bus; it has no ladder"
NO_REFERENCE: Final = "the gripper needs none: it homes against its stop"
NOT_SENT: Final = {
    **POSITIONS,
    "EMCY_8": HALTS,
    "REFERENCE_7": NO_REFERENCE,
}
"""Messages that none of our nodes sends, and why."""
NOT_HEARD: Final = {**POSITIONS, "EMCY_8": HALTS, "REFERENCE_7": NO_REFERENCE}
"""Messages that none of our nodes hears, and why."""


class Watched(Wire):
    """A contract that notes which messages it was asked to send and to receive."""

    def __init__(self) -> None:
        super().__init__()
        self.sent: set[str] = set()
        self.heard: set[str] = set()

    def sender(self, record: type[Record], node: int | None = None) -> Sender[Record]:
        self.sent.add(self.codec(record, node).name)
        return super().sender(record, node)

    def receiver(
        self, record: type[Record], node: int | None = None, refused: Any = None
    ) -> Receiver[Record]:
        self.heard.add(self.codec(record, node).name)
        return super().receiver(record, node, refused)


@pytest.fixture(scope="module")
def watched() -> Iterator[Watched]:
    """The contract after all nine nodes were made of it."""
    wire = Watched()
    Fleet(wire)
    yield wire


def test_our_nodes_send_every_message_but_those_listed(watched: Watched) -> None:
    due = {m.name for m in MESSAGES if OURS & set(m.senders)}
    assert due - watched.sent == set(NOT_SENT), "send it, or list it in NOT_SENT with the reason"


def test_our_nodes_hear_every_message_but_those_listed(watched: Watched) -> None:
    due = {m.name for m in MESSAGES if OURS & set(m.senders) and OURS & set(m.signals[0].receivers)}
    assert due - watched.heard == set(NOT_HEARD), "hear it, or list it in NOT_HEARD"


def test_nodes_send_and_hear_only_what_the_contract_gives_them() -> None:
    senders = {m.name: set(m.senders) for m in MESSAGES}
    receivers = {m.name: set(m.signals[0].receivers) for m in MESSAGES}
    wires = {}
    for joint in (1, 6):
        wires[joint] = Watched()
        JointNode(joint, wires[joint], 1)
    wires[GRIPPER] = Watched()
    GripperNode(wires[GRIPPER], 1)
    for number, wire in wires.items():
        name = DBC_NAMES[number]
        assert {m for m in wire.sent if name not in senders[m]} == set()
        # what it sends itself it hears from a second node of its number
        assert {m for m in wire.heard - wire.sent if name not in receivers[m]} == set()


# --- signals ------------------------------------------------------------------------------------

BY_POSITION: Final = re.compile(r"[fmoap]_[xyz]|(joint|torque|law|inertia)_[1-6]")
"""Elements of vectors: records are sliced where these are read."""
RESERVED: Final = {("SYNC", "reserved"), ("SETPOINT", "reserved"), ("ROWS", "reserved")}
NOT_READ: Final = RESERVED | {
    ("MEASURE", "index_seen"),  # for tools: a node reads the latched count of REFERENCE
    ("MEASURE", "board_fault"),  # of boards that are nodes
    ("FORCE", "saturated"),  # the estimate has its own bound of what can be measured
}
"""Signals that none of our nodes reads, and why."""
QUIET: Final = RESERVED | {
    ("MEASURE", "board_fault"),
    ("HEARTBEAT", "bus_offs"),  # a healthy bus has none; joints and gripper are not told
    ("HEARTBEAT", "overflows"),
    # what a start, a rigid move in joint coordinates and a healthy bus do not provoke
    *{("HEARTBEAT", "error_register"), ("HEARTBEAT", "discarded"), ("CONFIG_ACK", "status")},
    *{("NMT", "node"), ("NMT", "argument"), ("FORCE", "saturated"), ("DAC", "force_dac")},
    *{("ROWS", "damping"), ("ROWS", "selection"), ("ROWS", "specification")},
    *{("SETPOINT", "mode"), ("SETPOINT", "extras"), ("GRIPPER", "command"), ("GRIPPER", "force")},
}
"""Signals that stay 0 in the run of the test below."""
OCCASIONAL: Final = {"ESTOP", "EMCY", "COMPLY", "BIAS", "JOINT_SETPOINT", "POSITION"}
"""Messages that this run does not provoke, or that nothing sends yet."""


def test_something_reads_every_signal_but_those_listed() -> None:
    """By name: an attribute that is called so, anywhere but in the tester of nodes."""
    package = Path(__file__).parents[1] / "rfms_can"
    read = {
        node.attr
        for path in package.rglob("*.py")
        if not path.is_relative_to(package / "conform")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load)
    }
    unread = {
        (kind_of(message), signal.name)
        for message in MESSAGES
        for signal in payload_of(message)
        if signal.name not in read and not BY_POSITION.fullmatch(signal.name)
    }
    assert unread == NOT_READ, "read it, or list it in NOT_READ with the reason"


def test_every_signal_but_those_listed_is_filled_in_an_ordinary_run(wire: Wire) -> None:
    fleet = Fleet(wire, arm="puma560", scene="peg", sensor="good").enable()
    fleet.move((0.05,) * 6, 0.3)
    fleet.run(100)
    values: dict[tuple[str, str], set[float]] = {}
    kinds = {message.frame_id: kind_of(message) for message in MESSAGES}
    for frame in fleet.pump.sent:
        record = fleet.reader.read(frame).values
        for name, value in zip(record._fields, record, strict=True):
            values.setdefault((kinds[frame.id], name), set()).add(value)
    absent = set(kinds.values()) - {kind for kind, _ in values}
    assert absent == OCCASIONAL, "send it, or list it in OCCASIONAL"
    quiet = {signal for signal, seen in values.items() if seen == {0}}
    assert quiet == QUIET, "fill it, or list it in QUIET with the reason"


# --- parameters ---------------------------------------------------------------------------------


class Noting(dict[Parameter, float]):
    """A configuration that notes which of its values are read."""

    def __init__(self, values: Parameters) -> None:
        super().__init__(values)
        self.read: set[Parameter] = set()

    def __getitem__(self, parameter: Parameter) -> float:
        self.read.add(parameter)
        return super().__getitem__(parameter)


def read_by(make: Callable[[], JointNode | GripperNode]) -> set[Parameter]:
    """The parameters that a node reads when COMMIT closes its configuration, on any clock."""
    read: set[Parameter] = set()
    for clock in Clock:
        node = make()
        values = Noting(all_parameters(PUMA_260, "corke", 0.004, clock=clock)[node.number])
        digest = configuration_hash(dict(values))
        node.parameters = values
        commit = Config(Parameter.COMMIT, len(values), 0.0, digest)
        assert node._commit(commit, digest) is ConfigStatus.TAKEN
        read |= values.read
    return read


def test_a_joint_reads_every_parameter(wire: Wire) -> None:
    unread = set(PARAMETERS) - read_by(lambda: JointNode(2, wire, 2))
    assert unread == set(), "a parameter that the master sends and nothing reads"


def test_a_gripper_reads_those_it_is_given(wire: Wire) -> None:
    unread = GRIPPER_PARAMETERS - read_by(lambda: GripperNode(wire, 7))
    assert unread == {Parameter.ARM_ID}, "it is for its hash alone"


def test_the_master_sends_each_node_what_it_needs_and_nothing_else() -> None:
    sent = all_parameters(PUMA_260, "corke", 0.004)
    for joint in JOINTS:
        assert set(sent[joint]) == set(PARAMETERS), "joint_parameters: one too few or too many"
    assert set(sent[GRIPPER]) == GRIPPER_PARAMETERS, "gripper_parameters: one too few or too many"
