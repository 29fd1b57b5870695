"""From power-up to READY on the simulated bus: nothing that goes well is told as a fault."""

import pytest

from rfms_can.arm import ARMS
from rfms_can.arm.load import NOTHING
from rfms_can.compliance import ControlLaw
from rfms_can.dynamics.model import FULL, make_dynamics
from rfms_can.master.phases import Phase
from rfms_can.master.rows.compliance import Compliance
from rfms_can.master.rows.math_processor import MathProcessor
from rfms_can.master.rows.sets import RowSets
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import LAST_SET, NO_SET, Wire


@pytest.mark.system
@pytest.mark.parametrize("arm", ARMS)
def test_a_healthy_bring_up_leaves_no_fault_behind(wire: Wire, arm: str) -> None:
    rig = SimulatedRig(RunSettings(arm=arm), wire)
    rig.pump(lambda: rig.master.phase is Phase.READY)
    for node in (*rig.joints, rig.gripper):
        assert (node.error_register, dict(node.faults), node.discarded) == (0, {}, 0), node.name


def test_sets_of_rows_are_numbered_from_one_and_never_as_none() -> None:
    arm = ARMS["puma260"]
    processor = MathProcessor(arm, make_dynamics(arm, FULL), ControlLaw.WEIGHTED)
    sets, numbers = RowSets(processor, Wire().sender, arm.park), []
    assert sets.newest.number == NO_SET  # it is not sent
    for _ in range(LAST_SET + 2):
        sets.send((0.1, 1.2, -3.0, 0.2, -1.0, 0.3), Compliance(), NOTHING, [])
        numbers.append(sets.newest.number)
    assert numbers == [*range(1, LAST_SET + 1), 1, 2]
    assert NO_SET not in numbers
