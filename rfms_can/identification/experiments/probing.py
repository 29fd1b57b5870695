"""The probe on a bus: only plant and probe, before any joint node starts."""

import time
from typing import Final

from rfms_can.bus.driver import open_port
from rfms_can.bus.node_driver import NodeDriver
from rfms_can.bus.simulated import SimulatedBus
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import BusError, RfmsError
from rfms_can.identification.experiments.probe import Probe
from rfms_can.rig.child import Child
from rfms_can.rig.nodes import make_plant
from rfms_can.rig.processes import check_bus, start_hub, start_node
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import PLANT

SILENT_S: Final = 10.0
"""Timeout for the first answer of the boards, s."""


class WiringError(RfmsError):
    """A joint with wrong wiring, which must not be servoed."""


def probe(settings: RunSettings, attach: bool = False) -> Probe:
    """Probe all six joints of the arm on the bus of the settings.

    Args:
        settings: of the bus and the arm.
        attach: the boards are on the bus already; on a bus of processes a plant is started if not.

    Raises:
        BusError: the bus does not exist, or no board answers.
    """
    wire = Wire()
    node = Probe(settings.the_arm, wire, settings.boot_id(8), settings.master().period_ns)
    if settings.simulated:
        bus = SimulatedBus(BusTiming(settings.bit_rate, settings.data_bit_rate))
        for each in (make_plant(settings, wire), node):
            bus.attach(each)
        bus.run_until(lambda: node.done)
    else:
        _over_processes(node, settings, wire, attach)
    return node


def _over_processes(node: Probe, settings: RunSettings, wire: Wire, attach: bool) -> None:
    children: list[Child] = []
    try:
        hub = start_hub(settings)
        children += [] if hub is None else [hub]
        check_bus(settings)
        if not attach:
            children.insert(0, start_node(PLANT, settings, wire))
        port = open_port(settings.bus, node.accepts, client=node.name)
        try:
            until = time.monotonic() + SILENT_S
            driver = NodeDriver(node, port)
            driver.run_until(lambda: node.done or (not node.heard and time.monotonic() > until))
        finally:
            port.close()
    finally:
        for child in children:  # the plant before the hub it talks over
            child.signal()
            child.join()
    if not node.done:
        raise BusError(f"{settings.bus}: no board has answered in {SILENT_S:g} s")


def require_sound(found: Probe) -> None:
    """Refuse an arm with wrong wiring.

    Raises:
        WiringError: lists the joints and their faults.
    """
    problems = [finding.problem for finding in found.findings if finding.problem]
    if problems:
        raise WiringError("; ".join(problems))
