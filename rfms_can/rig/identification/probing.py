"""The probe on the simulated bus: plant and probe alone, before any joint node speaks."""

from rfms_can.bus.simulated import SimulatedBus
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import RfmsError
from rfms_can.master.probe import Probe
from rfms_can.rig.nodes import make_plant
from rfms_can.rig.settings import RunSettings
from rfms_can.wire import Wire


class WiringError(RfmsError):
    """A joint whose wires go the wrong way: nothing may be asked of it."""


def probe(settings: RunSettings) -> Probe:
    """Probe all six joints of the plant that the settings describe."""
    wire = Wire()
    bus = SimulatedBus(BusTiming(settings.bit_rate, settings.data_bit_rate))
    node = Probe(settings.the_arm, wire, settings.boot_id(8), settings.master().period_ns)
    for each in (make_plant(settings, wire), node):
        bus.attach(each)
    bus.run_until(lambda: node.done)
    return node


def require_sound(found: Probe) -> None:
    """Refuse an arm whose wires are wrong.

    Raises:
        WiringError: naming the joints and what is wrong.
    """
    problems = [finding.problem for finding in found.findings if finding.problem]
    if problems:
        raise WiringError("; ".join(problems))
