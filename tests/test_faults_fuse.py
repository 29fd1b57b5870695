"""``rfms run --fault``: a fault in a user's own run, on the simulated bus and inside processes."""

import json
import re

import pytest
from support.command_line import Rfms
from support.system import SHORT

from rfms_can.errors import RfmsError
from rfms_can.faults.catalogue import INJECTORS
from rfms_can.faults.context import ANYWHERE, Seam
from rfms_can.faults.fuse import Fault, in_process, parse_fault
from rfms_can.faults.tap import Tap
from rfms_can.rig.processes import OTHERS, make_node
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import MASTER, NODE_NAMES, PLANT
from rfms_can.wire.records import Sync
from rfms_can.wire.vocabulary import NodeState

HUB = RunSettings(bus="hub:x")


def test_a_fault_in_words() -> None:
    assert parse_fault("freeze_encoder:3@120") == Fault("freeze_encoder", 3, 120)
    assert parse_fault("freeze_encoder:3@120").at == PLANT
    assert parse_fault("freeze_dac:3@0").at == 3
    assert (parse_fault("stop_master@7").at, parse_fault("stop_master@7").node) == (MASTER, 1)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "give NAME:NODE@CYCLE"),
        ("freeze_encoder:3", "give NAME:NODE@CYCLE"),
        ("freeze_encoder:3@-1", "give NAME:NODE@CYCLE"),
        ("melt_encoder:3@1", "there are: .*freeze_encoder"),
        ("freeze_encoder@1", "give freeze_encoder:NODE@1"),
        ("freeze_encoder:7@1", "joint 7 does not exist"),
        ("freeze_encoder:0@1", "joint 0 does not exist"),
        ("ask_unreachable@1", "only rfms faults makes it"),
    ],
)
def test_what_is_no_fault_is_refused(text: str, why: str) -> None:
    with pytest.raises(RfmsError, match=why):
        parse_fault(text)


def test_faults_of_the_simulated_bus_are_refused_elsewhere() -> None:
    for name, injector in INJECTORS.items():
        if injector.seam is Seam.PROGRAM:
            continue
        fault = parse_fault(f"{name}:2@10")
        if injector.seam in ANYWHERE:
            in_process(fault, HUB)
        else:
            with pytest.raises(RfmsError, match="it needs bus 'sim'; on hub:x there are: "):
                in_process(fault, HUB)


def test_the_node_at_fault_alone_has_something_in_front_of_it(wire: Wire) -> None:
    for text in ("freeze_encoder:3@5", "freeze_dac:3@5"):
        fault = parse_fault(text)
        front = in_process(fault, HUB)
        nodes = [make_node(number, HUB, wire) for number in OTHERS]
        assert [n.name for n in nodes if isinstance(front(n), Tap)] == [NODE_NAMES[fault.at]]


def test_a_fuse_waits_for_its_cycle_of_an_enabled_arm(wire: Wire) -> None:
    tap = in_process(parse_fault("stop_joint:3@5"), HUB)(make_node(3, HUB, wire))
    assert isinstance(tap, Tap)
    sender = wire.sender(Sync)

    def hung_after(cycle: int, state: NodeState) -> bool:
        tap.on_frame(sender.frame(cycle, state, 0, wire.dbc_hash, 0), 0)
        return tap.hung

    assert not hung_after(9, NodeState.READY)
    assert not hung_after(4, NodeState.OPERATIONAL)
    assert hung_after(6, NodeState.OPERATIONAL), "also if the SYNC of its cycle was lost"


@pytest.mark.system
@pytest.mark.parametrize(
    ("fault", "complaint"),
    [
        ("freeze_error:2@30", r"joint 2: ERROR_2 tells"),
        ("reverse_encoder:1@60", r"joint 1: SENSOR_MISMATCH"),
        ("stop_joint:4@30", r"joint 4: no ERROR_4 for 3 cycles"),
        ("burst_dac:5@30", r"joint 5: no DAC_5 for 3 cycles"),
    ],
)
def test_a_fault_in_a_simulated_run_ends_it(rfms: Rfms, fault: str, complaint: str) -> None:
    ended = rfms("run", SHORT, "--fault", fault)
    assert ended.code == 1
    assert re.search(complaint, ended.err)


@pytest.mark.system
def test_one_lost_frame_ends_no_run(rfms: Rfms) -> None:
    ended = rfms("run", SHORT, "--fault", "lose_setpoint@30", "--json")
    assert ended.code == 0, ended.err
    assert json.loads(ended.out)["incomplete"] == 1


def test_where_a_motor_may_be_it_must_be_allowed(rfms: Rfms) -> None:
    bus = ("--bus", "socketcan:can7", "--fault", "freeze_dac:3@1")
    assert "give --allow-motion if it may" in rfms("run", SHORT, *bus).complaint
    other = rfms("run", SHORT, *bus, "--allow-motion").complaint
    assert "can7" in other and "--allow-motion" not in other, "it got as far as the bus"
    attached = rfms("run", SHORT, "--bus", "hub:x", "--attach", "--fault", "freeze_dac:3@1")
    assert "which --attach leaves to others" in attached.complaint


@pytest.mark.processes
@pytest.mark.parametrize(
    ("fault", "complaint"),
    [
        ("freeze_error:2@30", r"joint 2: ERROR_2 tells"),
        ("freeze_encoder:1@30", r"joint 1: SENSOR_MISMATCH"),
        ("nan_setpoint@30", r"BAD_FRAMES \(3, bound 10\): SETPOINT_1 of master|SETPOINT_MISSING"),
    ],
)
def test_a_fault_inside_a_process_ends_a_run_on_a_hub(
    rfms: Rfms, fault: str, complaint: str
) -> None:
    ended = rfms("run", SHORT, "--bus", "hub:faults", "--barrier", "0.3", "--fault", fault)
    assert ended.code == 1
    assert re.search(complaint, ended.err), ended.err
