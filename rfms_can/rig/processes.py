"""The nine nodes as processes on a hub or a CAN interface; this process is the master.

One warm parent forks the others, so that a slow machine imports the heavy libraries once.
"""

import gc
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Final

from rfms_can.bus.driver import open_port
from rfms_can.bus.hub.address import live_hubs
from rfms_can.bus.hub.server import serve
from rfms_can.bus.node_driver import NodeDriver, run_node
from rfms_can.bus.port import Port
from rfms_can.bus.timing import BusTiming
from rfms_can.bus.url import HUB, parse_bus_url
from rfms_can.errors import BusError
from rfms_can.master.node import MasterNode
from rfms_can.node.protocol import Node
from rfms_can.rig.child import Child, Stop, describe
from rfms_can.rig.nodes import make_gripper, make_joint, make_master, make_plant
from rfms_can.rig.recorder import Recorder
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.truth import SceneResult
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import GRIPPER, JOINTS, MASTER, NODE_NAMES, PLANT
from rfms_can.wire.records import Heartbeat, Sync

LOOK_EVERY: Final = 512
"""Frames between two checks of the children; when no frame comes they are checked immediately."""
HUB_PATIENCE_S: Final = 10.0

OTHERS: Final = (*JOINTS, GRIPPER, PLANT)
"""Nodes other than the master."""


Front = Callable[[Node], Node]
"""What stands in front of a node: the node itself, or one that sees what it hears and sends."""


def as_made(node: Node) -> Node:
    """Nothing stands in front of it."""
    return node


def make_node(number: int, settings: RunSettings, wire: Wire) -> Node:
    """The node of a number, the master excepted."""
    if number in JOINTS:
        return make_joint(number, settings, wire)
    if number == GRIPPER:
        return make_gripper(settings, wire)
    return make_plant(settings, wire)


def start_node(number: int, settings: RunSettings, wire: Wire, front: Front = as_made) -> Child:
    """A node in a process of its own; ``front`` may put another one in front of it."""

    def body(stop: Stop) -> None:
        node = front(make_node(number, settings, wire))
        port = open_port(settings.bus, node.accepts, client=node.name)
        try:
            run_node(node, port, stop=stop)
        finally:
            port.close()

    return Child(NODE_NAMES[number], body)


def start_hub(settings: RunSettings) -> Child | None:
    """Start the hub of a ``hub:NAME`` URL, unless it runs already; None if nothing was started.

    Raises:
        BusError: it did not start.
    """
    url = parse_bus_url(settings.bus)
    if url.interface != HUB or url.channel in live_hubs():
        return None
    timing = BusTiming(settings.bit_rate, settings.data_bit_rate)

    def notice(line: str) -> None:
        sys.stderr.write(f"hub {url.channel!r}: {line}\n")

    def body(_: Stop) -> None:
        only = (signal.SIGTERM,)  # Ctrl-C is the parent's
        serve(url.channel, timing, stop_signals=only, notice=notice)

    child = Child(f"hub {url.channel}", body)
    until = time.monotonic() + HUB_PATIENCE_S
    while not _answers(settings):
        if not child.alive or time.monotonic() > until:
            child.signal()
            raise BusError(f"hub {url.channel!r} did not come up; see its own message above")
        time.sleep(0.01)
    return child


def _answers(settings: RunSettings) -> bool:
    try:
        check_bus(settings)
    except BusError:
        return False
    return True


def check_bus(settings: RunSettings) -> None:
    """Report a missing bus once, instead of once per node.

    Raises:
        BusError: the bus does not exist.
    """
    open_port(settings.bus, frozenset(), client="check").close()


def check_no_master(settings: RunSettings) -> None:
    """Refuse a bus that a master drives, before any node of ours is on it.

    Its joints would find a second node of their number there, and stop.

    Raises:
        BusError: SYNC, or the HEARTBEAT of a master, is heard.
    """
    wire = Wire()
    sent = {wire.id(Sync): "SYNC", wire.id(Heartbeat, MASTER): f"HEARTBEAT_{MASTER}"}
    port = open_port(settings.bus, frozenset(sent), client="check")
    try:
        until = time.monotonic() + settings.master().listening_s
        while (left := until - time.monotonic()) > 0.0:
            frame = port.recv(left)
            if frame is not None:
                raise BusError(
                    f"bus {settings.bus}: another master drives it, it sends {sent[frame.id]}: "
                    f"stop it first, or take another bus"
                )
    finally:
        port.close()


def open_master_port(settings: RunSettings, master: MasterNode) -> Port:
    """The master's port: echoes its own ROWS once they are sent, and counts foreign frames.

    Raises:
        BusError: the bus does not exist.
    """

    def count(_kind: str) -> None:
        master.foreign += 1

    return open_port(settings.bus, master.accepts, client=master.name, echo=True, on_foreign=count)


class ProcessRig:
    """Master here, the other eight nodes in processes of their own.

    Args:
        settings: of the run.
        record: candump log to write, or None.
        elsewhere: nodes that are started elsewhere: real boards, or other terminals.
        front: what stands in front of each node, in its process.

    Attributes:
        master: the master.
        children: the processes of nodes.
        recorder: the process that writes the log, or None.

    Raises:
        BusError: the bus does not exist, or another master drives it.
    """

    def __init__(
        self,
        settings: RunSettings,
        record: Path | None = None,
        elsewhere: frozenset[int] = frozenset(),
        front: Front = as_made,
    ) -> None:
        wire = Wire()
        self.children: list[Child] = []
        self._hub: list[Child] = []
        self._recorder: list[Child] = []
        self.recorder: Recorder | None = None
        self._port: Port | None = None
        gc.freeze()  # keep the collector off the memory that the children share
        try:
            hub = start_hub(settings)
            self._hub += [] if hub is None else [hub]
            check_bus(settings)
            here = [n for n in OTHERS if n not in elsewhere]
            if hub is None and here:
                check_no_master(settings)
            if record is not None:
                self.recorder = Recorder(record, settings)
                self._recorder.append(self.recorder)
            self.children = [start_node(n, settings, wire, front) for n in here]
            self.master = make_master(settings, wire)
            self._port = open_master_port(settings, self.master)
        except BaseException:
            self.close()
            raise
        self._statistics = self._port.statistics
        self._driver = NodeDriver(front(self.master), self._port)
        self._look = 0
        self._buried: set[int] = set()  # processes whose end has been a fault already
        self._received = self._begun = 0

    def pump(self, condition: Callable[[], bool]) -> None:
        """Run until a condition holds. The death of a node's process is a fault of the run.

        Raises:
            BusError: the bus has gone.
        """

        def held() -> bool:
            received = self._statistics["received"]
            self._look -= 1
            if self._look <= 0 or received == self._received:
                self._look = LOOK_EVERY
                self._look_after_children()
            self._received = received
            return condition()

        self._driver.run_until(held)

    def _look_after_children(self) -> None:
        for child in self.children:
            if not child.alive and child.pid not in self._buried and self.master.fault is None:
                self._buried.add(child.pid)
                self.master.lose(f"the process of {describe(child)}", child.name)

    def begin_measuring(self) -> None:
        """Start counting frames."""
        self._begun = self._count()

    def _count(self) -> int:
        counts = self._statistics
        return counts["sent"] + counts["received"] - self.master.heard_back

    @property
    def load(self) -> float | None:
        """Unknown: bus time is not real time here."""
        return None

    @property
    def scene(self) -> SceneResult | None:
        """Unknown: the plant is another process."""
        return None

    @property
    def frames(self) -> int:
        """Frames the master has sent or heard since ``begin_measuring``."""
        return self._count() - self._begun

    def close(self) -> None:
        """End all children: nodes, then the recorder once it has read everything, then the hub."""
        for group in (self.children, self._recorder, self._hub):
            for child in group:
                child.signal()
            for child in group:
                child.join()
        if self._port is not None:
            self._port.close()
            self._port = None
