"""What ports count reaches heartbeats, the master, and the result of a run."""

from collections import Counter
from collections.abc import Callable, Sequence

import pytest
from support.system import SHORT

from rfms_can.bus.node_driver import NodeDriver
from rfms_can.bus.port import counts_of
from rfms_can.bus.simulated import SimulatedBus
from rfms_can.cli.report import console, print_result
from rfms_can.node.endpoint import Endpoint
from rfms_can.node.port_counts import PortCounts
from rfms_can.rig.nodes import make_master, make_plant
from rfms_can.rig.program import load_program
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Heartbeat, Nmt, Sync
from rfms_can.wire.vocabulary import Command, NodeState


class CountingPort:
    """A port that has counted something, and carries nothing."""

    def __init__(self, **counts: int) -> None:
        self.statistics: Counter[str] = Counter(counts)

    def send(self, frames: Sequence[Frame]) -> None:
        raise AssertionError("nothing was to be sent")

    def recv(self, timeout_s: float) -> Frame | None:
        return None

    def fileno(self) -> int:
        return -1

    def close(self) -> None:
        pass


def heartbeat(wire: Wire, node: Endpoint) -> Heartbeat:
    """What a node tells when it is asked to announce itself."""
    frames = [frame for now_ns in (0, 10**9, 2 * 10**9) for frame in node.on_time(now_ns)]
    announce = wire.sender(Nmt).frame(Command.ANNOUNCE, 0, 0)
    frames += [] if node.name == "master" else node.on_frame(announce, 1)
    codec = wire.codec(Heartbeat, node.number)
    beat = codec.unpack([frame for frame in frames if frame.id == codec.id][-1].data)
    assert isinstance(beat, Heartbeat)
    return beat


@pytest.mark.parametrize("make", [make_plant, make_master])
@pytest.mark.parametrize(
    ("counts", "told"),
    [
        ({}, (0, 0)),
        ({"bus_off": 2, "tx_overflow": 3, "rx_overflow": 4, "sent": 9, "foreign": 9}, (2, 7)),
        ({"bus_off": 16, "tx_overflow": 256}, (15, 255)),  # all that its fields hold
    ],
)
def test_the_heartbeat_tells_what_the_port_has_counted(
    wire: Wire,
    make: Callable[[RunSettings, Wire], Endpoint],
    counts: dict[str, int],
    told: tuple[int, int],
) -> None:
    node = make(RunSettings(), wire)
    NodeDriver(node, CountingPort(**counts))
    beat = heartbeat(wire, node)
    assert (beat.bus_offs, beat.overflows) == told


def test_on_the_simulated_bus_the_controller_counts(wire: Wire) -> None:
    """A plant that answers a SYNC has more to send than two transmit buffers hold."""
    plant = make_plant(RunSettings(), wire)
    bus = SimulatedBus()
    controller = bus.attach(plant, tx_capacity=2)
    bus.run_until(10**7)
    sync = wire.sender(Sync).frame(1, NodeState.PREOP, 0, wire.dbc_hash)
    measures = plant.on_frame(sync, bus.now_ns)
    assert len(measures) == 7
    bus.send(controller, measures)
    assert controller.counts() == PortCounts(0, 5)
    controller.bus_off = True
    beat = heartbeat(wire, plant)
    assert (beat.bus_offs, beat.overflows) == (1, 5)


def test_counts_of_a_port() -> None:
    assert counts_of(Counter(rx_overflow=2, sent=5)) == (0, 2)


@pytest.mark.system
def test_the_result_of_a_run_names_the_node() -> None:
    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        rig.plant.port_counts = lambda: PortCounts(0, 12)
        rig.master.port_counts = lambda: PortCounts(1, 300)

    troubled = execute(load_program(SHORT), RunSettings(), watch=watch).result
    assert troubled.bus_offs == {"master": 1}
    assert troubled.overflows == {"plant": 12, "master": 300}
    assert troubled.as_dict()["overflows"] == troubled.overflows
    calm = execute(load_program(SHORT), RunSettings()).result
    assert (calm.bus_offs, calm.overflows) == ({}, {})
    told = {}
    for result in (troubled, calm):
        with console.capture() as captured:
            print_result("a run", result)
        told[result is troubled] = captured.get()
    assert "plant: 12, master: 300" in told[True]
    assert "bus-off" in told[True]
    assert "bus-off" not in told[False]
    assert "overflows" not in told[False]
