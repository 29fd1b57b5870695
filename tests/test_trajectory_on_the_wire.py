"""The golden trajectories end to end: generator, SETPOINT frames, each joint's own solution."""

import pytest
from support.trajectory import golden_rig

from rfms_can.setpoint.frames import setpoint_of, values_of
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Setpoint
from rfms_can.wire.vocabulary import Blend


@pytest.mark.parametrize("name", ["static", "tracking"])
def test_golden_trajectories_survive_the_bus(name: str, wire: Wire) -> None:
    rig, rows = golden_rig(name, Blend.THESIS)
    senders = [wire.sender(Setpoint, pose) for pose in (1, 2)]
    receivers = [wire.receiver(Setpoint, pose) for pose in (1, 2)]
    largest = 0.0
    for cycle, row in enumerate(rows):
        sent = rig.generator.tick()
        poses = ((sent.T6_1, sent.configuration_1), (sent.T6_2, sent.configuration_2))
        heard: list[Setpoint | None] = [None, None]
        for index, (pose, configuration) in enumerate(poses):
            if pose is not None:
                frame = senders[index].frame(*values_of(sent, pose, configuration, cycle))
                heard[index] = receivers[index].take(frame)
        first, second = heard
        assert first is not None and (first.poses == 2) is (second is not None)
        setpoint = setpoint_of(first, second)
        for joint, solver, reference in zip(rig.joints, rig.solvers, row[7], strict=True):
            largest = max(largest, abs(joint.tick(setpoint, solver.solve) - reference))
    assert largest < 1e-4
