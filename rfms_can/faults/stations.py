"""Faults of the rig: controllers off the bus or full, late nodes, strangers, a seized brake."""

from collections.abc import Sequence
from typing import Final

from rfms_can.bus.simulated import SimulatedBus
from rfms_can.faults import boards, nodes
from rfms_can.faults.site import Site
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.joint_nodes.sensing import HARD_MARGIN_RAD, SOFT_MARGIN_RAD
from rfms_can.master.node import MasterNode
from rfms_can.master.trajectory.braking import STOPPING_FRACTION
from rfms_can.node.protocol import NOTHING, Node
from rfms_can.plant.faulty_board import FaultyBoard
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Dac, Sync
from rfms_can.wire.vocabulary import NodeState

PUSH_FRACTION: Final = 0.45
"""Torque over a motor's limit with which a joint is pushed: friction is 0.28 of it."""
OVERPOWERING: Final = 1.3
"""The same of a push that a motor cannot withstand."""
LATE: Final = 0.7
"""Part of a period by which a late master is late."""
FLOOD_ID: Final = 0x010
"""Identifier of a flood: urgent, and of no message of ours."""
FLOOD_NS: Final = 200_000
"""Time between two frames of 64 bytes of the flood, ns: 85 % of the bus at 1/5 Mbit/s."""
OTHER_BOOT: Final = 0xB007
JOINED_LATENCY_NS: Final = 20_000
"""Of a node that joins: it answers never quite at the same instant as another, ns."""


class Stranger:
    """A node that no one has asked for: sends by the clock, hears nothing.

    Args:
        name: on the simulated bus, which tells senders apart by it.
        at_ns: of the first frame.
        every_ns: between two.
    """

    def __init__(self, name: str, at_ns: int, every_ns: int) -> None:
        self.name = name
        self.accepts: frozenset[int] = frozenset()
        self._at_ns, self._every_ns = at_ns, every_ns

    def frames(self) -> Sequence[Frame]:
        """What it sends next."""
        return NOTHING

    def on_frame(self, _frame: Frame, _now_ns: int) -> Sequence[Frame]:
        """It hears nothing."""
        return NOTHING

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Send."""
        if now_ns < self._at_ns:
            return NOTHING
        self._at_ns += self._every_ns
        return self.frames()

    def next_deadline_ns(self) -> int | None:
        """When it sends."""
        return self._at_ns


class Flood(Stranger):
    """A babbling idiot: long frames of an urgent identifier, again and again."""

    def frames(self) -> Sequence[Frame]:
        """One of them."""
        return (Frame(FLOOD_ID, bytes(64)),)


class ForeignSync(Stranger):
    """Sends SYNC, with a counter and cycles of its own, between those of the master."""

    def __init__(self, site: Site, at_ns: int) -> None:
        super().__init__("stranger", at_ns, site.context.period_ns)
        self._sender = site.context.wire.sender(Sync)
        self._cycle = site.context.draw.randrange(1 << 16)
        self._hash = site.context.wire.dbc_hash

    def frames(self) -> Sequence[Frame]:
        """The next SYNC."""
        self._cycle += 1
        return (self._sender.frame(self._cycle, NodeState.OPERATIONAL, 0, self._hash, 0),)


class ForeignDac(Stranger):
    """Sends the DAC of the joint at fault, of its cycle, with the torque the other way."""

    def __init__(self, site: Site, at_ns: int) -> None:
        super().__init__("stranger", at_ns, site.context.period_ns)
        self._sender = site.context.wire.sender(Dac, site.context.node)
        self._site = site

    def frames(self) -> Sequence[Frame]:
        """A code of its own."""
        cycle = self._site.rig.master.cycle.number & 0xFF
        return (self._sender.frame(-1000, 0, cycle),)


def _named(node: Node, name: str) -> Node:
    """A second node: on the simulated bus names tell senders apart."""
    vars(node)["name"] = name
    return node


def bus_off(site: Site) -> None:
    """The controller of the node has gone bus-off."""
    site.touch()
    site.rig.bus.switch_off(site.controller(site.context.node))


def full_once(site: Site) -> None:
    """The node's transmit queue takes no frame for one period (ENOBUFS)."""
    _full(site, site.context.period_ns)


def full_for_ever(site: Site) -> None:
    """The node's transmit queue takes no frame any more."""
    _full(site, None)


def _full(site: Site, duration_ns: int | None) -> None:
    controller = site.controller(site.context.node)
    capacity, controller.tx_capacity = controller.tx_capacity, 0
    site.touch_at_loss(controller)
    if duration_ns is not None:
        site.later(duration_ns, lambda: setattr(controller, "tx_capacity", capacity))


def late_once(site: Site) -> None:
    """The master hands the frames of one cycle over late."""
    _late(site, site.context.period_ns // 2)


def late_for_ever(site: Site) -> None:
    """The master hands its frames over late: it needs most of a cycle for each answer."""
    _late(site, None)


def _late(site: Site, duration_ns: int | None) -> None:
    controller = site.controller(MASTER)
    deadline_ns = site.rig.master.next_deadline_ns() or site.rig.bus.now_ns
    controller.latency_ns = round(LATE * site.context.period_ns)
    site.touch(deadline_ns)
    if duration_ns is not None:
        ends_ns = deadline_ns + duration_ns - site.rig.bus.now_ns
        site.later(ends_ns, lambda: setattr(controller, "latency_ns", 0))


def flood(site: Site) -> None:
    """A stranger floods the bus with urgent frames."""
    _join(site, Flood("stranger", site.rig.bus.now_ns, FLOOD_NS))


def foreign_sync(site: Site) -> None:
    """A stranger sends SYNC in the middle of each cycle."""
    _join(site, ForeignSync(site, site.rig.bus.now_ns + site.context.period_ns // 2))


def foreign_dac(site: Site) -> None:
    """A stranger sends DAC of the joint at fault, late in each cycle."""
    _join(site, ForeignDac(site, site.rig.bus.now_ns + 4 * site.context.period_ns // 5))


def second_joint(site: Site) -> None:
    """Another node of the joint's number is switched on."""
    context = site.context
    node = JointNode(context.node, context.wire, OTHER_BOOT)
    _join(site, _named(node, f"second joint {context.node}"))


def second_master(site: Site) -> None:
    """Another master is switched on."""
    context, settings = site.context, site.rig.master.settings
    _join(
        site, _named(MasterNode(context.arm, context.wire, OTHER_BOOT, settings), "second master")
    )


def _join(site: Site, node: Node) -> None:
    bus: SimulatedBus = site.rig.bus
    site.touch_at_frame_of(node.name)
    bus.attach(node, latency_ns=JOINED_LATENCY_NS)


def seized_brake(site: Site) -> None:
    """The brake of the joint holds, whatever the plant tells it."""
    site.rig.plant.physics.seize_brake(site.context.index)
    site.touch()


def run_to_the_end(site: Site) -> None:
    """The set-point turns joint 1 on; the effect is when it can no longer stop inside its range."""
    nodes.runs_on(site.context, site.tap(MASTER))
    site.touch_when(lambda: _comes_to_rest_at(site) > site.context.arm.joint_limits[0][1])


def _comes_to_rest_at(site: Site) -> float:
    """Where joint 1 would come to rest by a controlled stop, rad; it moves up."""
    physics, braking = site.rig.plant.physics, site.context.arm.acceleration_limits[0]
    speed = max(physics.true_qd[0], 0.0)
    return physics.true_q[0] + 0.5 * speed**2 / (STOPPING_FRACTION * braking)


def push_to_the_end(site: Site) -> None:
    """Joint 1 is pushed up, by a little more than its friction; the effect is when it can no longer
    stop inside its range."""
    _push(site, PUSH_FRACTION)
    bound = site.context.arm.joint_limits[0][1] + SOFT_MARGIN_RAD
    site.touch_when(lambda: _comes_to_rest_at(site) > bound)


def push_through(site: Site) -> None:
    """Joint 1 is pushed up by more than its motor can do; the effect is when it is past the angle
    at which its torque has to go off."""
    _push(site, OVERPOWERING)
    bound = site.context.arm.joint_limits[0][1] + HARD_MARGIN_RAD
    site.touch_when(lambda: site.rig.plant.physics.true_q[0] > bound)


def _push(site: Site, fraction: float) -> None:
    """From outside, with a part of the motor's torque limit."""
    limit = site.context.arm.drives[0].torque_limit
    site.rig.plant.physics.push(0, fraction * limit)


def drive_to_the_end(site: Site) -> None:
    """The amplifier drives joint 1 up; the effect is when it leaves its range."""
    physics, damage = site.rig.plant.physics, boards.amplifier_drives_up(site.context)
    physics.exchange_board(0, lambda board: FaultyBoard(board, damage, lambda: None))
    upper = site.context.arm.joint_limits[0][1]
    site.touch_when(lambda: physics.true_q[0] >= upper)
