"""Faults in a user's own run: put in at a cycle, on the simulated bus or inside a node's process.

``NAME:NODE@CYCLE``, e.g. ``freeze_encoder:3@120``: the injector of that name, the joint at fault
(or about whose frames it is), and the control cycle from which on it is there, as SYNC counts.
Faults at a node's frames and at a board work in whatever process the node runs; the others need bus
``sim``.
"""

import re
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

from rfms_can.errors import RfmsError
from rfms_can.faults.catalogue import INJECTORS, JOINT, Injector, inject
from rfms_can.faults.context import ANYWHERE, Context, Seam
from rfms_can.faults.forge import Forge
from rfms_can.faults.site import Site
from rfms_can.faults.tap import Tamper, Tap, unchanged
from rfms_can.faults.trial import drawn_by
from rfms_can.node.protocol import Node
from rfms_can.plant.faulty_board import FaultyBoard
from rfms_can.plant.node import PlantNode
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS, MASTER, NODE_NAMES, PLANT
from rfms_can.wire.records import Sync
from rfms_can.wire.vocabulary import NodeState

_GRAMMAR: Final = re.compile(r"(?P<name>\w+)(?::(?P<node>\d+))?@(?P<cycle>\d+)")
EXAMPLE: Final = "freeze_encoder:3@120"
ANY_JOINT: Final = 1
"""Joint that a fault of another node is about, if none is named."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault that is put into a run.

    Attributes:
        name: of the injector.
        node: the joint at fault, or about whose frames it is.
        cycle: control cycle with whose SYNC it is put in.
    """

    name: str
    node: int
    cycle: int

    @property
    def injector(self) -> Injector:
        """From the catalogue."""
        return INJECTORS[self.name]

    @property
    def at(self) -> int:
        """Number of the node in whose process it is put in."""
        if self.injector.seam is Seam.BOARD:
            return PLANT
        return self.injector.node or self.node


def parse_fault(text: str) -> Fault:
    """The fault of ``NAME:NODE@CYCLE``.

    Raises:
        RfmsError: it is none, or no such injector or joint exists, or only ``rfms faults`` has it.
    """
    found = _GRAMMAR.fullmatch(text)
    if found is None:
        raise RfmsError(f"fault {text!r}: give NAME:NODE@CYCLE, e.g. {EXAMPLE}")
    name, node, cycle = found["name"], found["node"], int(found["cycle"])
    if name not in INJECTORS:
        raise RfmsError(f"fault {name!r} does not exist; there are: {', '.join(sorted(INJECTORS))}")
    injector = INJECTORS[name]
    if injector.seam is Seam.PROGRAM:
        raise RfmsError(f"fault {name!r} is a program's request: only rfms faults makes it")
    if node is None and injector.node == JOINT:
        raise RfmsError(f"fault {name!r} is of a joint: give {name}:NODE@{cycle}, NODE 1 to 6")
    joint = ANY_JOINT if node is None else int(node)
    if joint not in JOINTS:
        raise RfmsError(f"fault {name!r}: joint {joint} does not exist; there are 1 to 6")
    return Fault(name, joint, cycle)


def _context(fault: Fault, settings: RunSettings, wire: Wire, now_ns: Callable[[], int]) -> Context:
    return Context(
        arm=settings.the_arm,
        period_ns=settings.master().period_ns,
        wire=wire,
        forge=Forge(wire),
        draw=drawn_by(f"{fault.name}:{fault.node}@{fault.cycle}:{settings.seed}"),
        node=fault.node,
        now_ns=now_ns,
        touch=lambda *_: None,
    )


class _Fuse:
    """Waits for the SYNC of a cycle of the enabled arm."""

    def __init__(self, context: Context, cycle: int) -> None:
        self._context, self._cycle = context, cycle
        self._sync = context.wire.id(Sync)

    def lit_by(self, frame: Frame) -> bool:
        """Whether a frame is that SYNC, or a later one."""
        if frame.id != self._sync:
            return False
        sync = self._context.forge.read(frame)
        enabled = sync is not None and sync.state == NodeState.OPERATIONAL
        return bool(enabled and sync.cycle >= self._cycle)


def on_rig(fault: Fault, settings: RunSettings, rig: SimulatedRig) -> None:
    """Put a fault into a simulated system when its cycle begins."""
    context = _context(fault, settings, rig.master.wire, lambda: rig.bus.now_ns)
    site, fuse = Site(rig, context), _Fuse(context, fault.cycle)
    waiting = True

    def look(_: int, frame: Frame, sender: str) -> None:
        nonlocal waiting
        if waiting and sender == NODE_NAMES[MASTER] and fuse.lit_by(frame):
            waiting = False
            inject(fault.name, site)

    rig.bus.observers.append(look)


def in_process(fault: Fault, settings: RunSettings) -> Callable[[Node], Node]:
    """What stands in front of each node of a run on a real bus; only that at fault has a tap.

    Raises:
        RfmsError: the fault needs the simulated bus.
    """
    if fault.injector.seam not in ANYWHERE:
        names = sorted(n for n, injector in INJECTORS.items() if injector.seam in ANYWHERE)
        raise RfmsError(
            f"fault {fault.name!r} is of {fault.injector.seam.value}: it needs bus 'sim'; on "
            f"{settings.bus} there are: {', '.join(names)}"
        )
    return lambda node: _tapped(fault, settings, node) if _is_at_fault(fault, node) else node


def _is_at_fault(fault: Fault, node: Node) -> bool:
    return node.name == NODE_NAMES[fault.at]


def _tapped(fault: Fault, settings: RunSettings, node: Node) -> Tap:
    """A node behind a tap, which the fault is put into when its cycle begins."""
    context = _context(fault, settings, Wire(), time.monotonic_ns)
    tap, fuse = Tap(node), _Fuse(context, fault.cycle)
    way = "out" if fault.at == MASTER else "into"  # the master sends SYNC, the others hear it

    def wait(frame: Frame) -> Iterable[Frame]:
        if not fuse.lit_by(frame):
            return (frame,)
        setattr(tap, way, unchanged)
        _put_in(fault, context, tap)
        tampered: Tamper = getattr(tap, way)
        return () if tap.hung else tampered(frame)

    setattr(tap, way, wait)
    return tap


def _put_in(fault: Fault, context: Context, tap: Tap) -> None:
    """Tamper with the node, or with a board of the plant."""
    if fault.injector.seam is Seam.TAP:
        fault.injector.make(context, tap)
        return
    assert isinstance(tap.node, PlantNode)
    damage = fault.injector.make(context)
    tap.node.physics.exchange_board(
        context.index, lambda board: FaultyBoard(board, damage, lambda: None)
    )
