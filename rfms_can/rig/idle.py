"""A master without a program: homes the arm, then waits with the brakes on."""

from collections.abc import Callable

from rfms_can.bus.node_driver import NodeDriver
from rfms_can.errors import FaultError
from rfms_can.master.node import MasterNode
from rfms_can.rig.processes import open_master_port
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import MASTER


def run_idle(settings: RunSettings, stop: Callable[[], bool]) -> None:
    """Run cycles, paced by the control period, until ``stop`` returns True.

    Raises:
        FaultError: the bus could not be brought up, or a fault was latched.
    """
    master = MasterNode(
        settings.the_arm, Wire(), settings.boot_id(MASTER), settings.master(paced=True)
    )
    port = open_master_port(settings, master)
    driver = NodeDriver(master, port)
    try:
        driver.run_until(lambda: stop() or master.fault is not None)
        if master.fault is None:
            master.stop()
            driver.run_until(lambda: master.ended or master.next_deadline_ns() is None)
    finally:
        port.close()
    if master.fault is not None:
        raise FaultError(master.fault)
