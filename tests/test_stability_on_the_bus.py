"""What the analysis calls stable comes to rest through the bus: nodes, rows, boards, MuJoCo.

Only friction is left out. The poles are those of the nodes' own gains and damping.
"""

import numpy as np
import pytest
from support.fleet import PushedFleet

from rfms_can.analysis.stability import Analyst, ControlLaw, Study, Verdict
from rfms_can.arm import arm_by_name
from rfms_can.arm.load import NOTHING
from rfms_can.compliance import Selection, compliance_jacobian
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.servo import Servo
from rfms_can.kinematics import jacobian
from rfms_can.master.rows.compliance import Compliance
from rfms_can.master.rows.math_processor import COMPLIANT_DAMPING
from rfms_can.master.start_up.node_parameters import parameters_for
from rfms_can.rig.settings import RunSettings
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Rows
from rfms_can.wire.vocabulary import Parameter

WORD = "fx fy rx ry"
TOOL_OF = {length: Transform.translation(0.0, 0.0, length) for length in (0.1, 0.2)}
WAY = (0.15, -0.1, 0.1, 0.0, 0.3, 0.0)


def analyst(length: float, arm: str) -> Analyst:
    return Analyst(
        Study(
            arm_by_name(arm),
            Selection.parse(WORD),
            TOOL_OF[length],
            ControlLaw.WEIGHTED,
            compliant_rate=COMPLIANT_DAMPING,
        )
    )


@pytest.mark.system
@pytest.mark.parametrize("arm", ["puma260", "puma560"])
@pytest.mark.parametrize("length", [0.1, 0.2])
def test_a_peg_that_complies_in_the_air_comes_to_rest(wire: Wire, arm: str, length: float) -> None:
    fleet = PushedFleet(wire, arm=arm, friction="none")
    fleet.enable()
    fleet.comply(WORD)
    fleet.move(WAY, 0.6, frame=TOOL_OF[length])
    fleet.run(160)
    end = fleet.master.motion.commanded.theta
    analysis = analyst(length, arm).analyse(end)
    assert analysis.verdict is Verdict.STABLE
    assert analysis.sampled_stable
    at = []
    for _ in range(500):  # two seconds
        fleet.run(1)
        at.append(fleet.plant.physics.true_q)
    assert fleet.master.fault is None
    speeds = np.abs(np.diff(np.array(at), axis=0)).max(axis=1) / 0.004
    late, later = speeds[250:375].max(), speeds[375:].max()
    # what complies has no stiffness: half a code of the DAC is enough to let it creep
    assert later < 6e-3
    assert later < 1.5 * late + 1e-3
    J = compliance_jacobian(np.array(jacobian(fleet.master.arm, at[-1])), TOOL_OF[length])
    errors = np.array(fleet.master.inputs.errors)
    rigid = ~Selection.parse(WORD).mask
    assert np.abs((J @ errors)[rigid]).max() < 5e-4


def test_the_sampled_model_is_that_of_the_nodes(wire: Wire) -> None:
    """K, B and mu as the analysis has them, and as six servos make torques of the rows."""
    rng = np.random.default_rng(3)
    q = (0.3, 0.4, -2.0, 0.2, 0.9, 0.1)
    frame, selection = Transform.translation(0.0, 0.0, 0.15), Selection.parse(WORD)
    for law in (ControlLaw.WEIGHTED, ControlLaw.HYBRID, ControlLaw.FREE_JOINT):
        fleet = PushedFleet(wire, arm="puma560", friction="none", law=law.value)
        arm = fleet.master.arm
        sets = fleet.master.rows
        sets.send(q, Compliance().changed(selection, frame), NOTHING, [])
        study = Study(arm, selection, frame, law, compliant_rate=COMPLIANT_DAMPING)
        loop = Analyst(study).loop(q)
        settings = RunSettings(arm="puma560", friction="none", law=law.value).master()
        parameters = parameters_for(arm, settings)
        e, v = rng.normal(scale=1e-3, size=6), rng.normal(scale=1e-2, size=6)
        torques = []
        for joint, values in enumerate(sets.newest.values, start=1):
            rows = RowSets(joint)
            rows.activate(Rows._make((*values, 0)))
            servo = Servo({**parameters[joint], Parameter.KI: 0.0}, joint)
            torques.append(servo.torque(e.tolist(), v.tolist(), (0.0,) * 6, rows, 0.0))
        wanted = loop.stiffness @ e + loop.damping @ v
        assert torques == pytest.approx(wanted.tolist(), rel=1e-5, abs=1e-7), law


@pytest.mark.system
@pytest.mark.parametrize(("arm", "newton"), [("puma260", 1.0), ("puma560", 4.0)])
def test_a_newton_moves_what_complies_as_its_mass_and_damping_say(
    wire: Wire, arm: str, newton: float
) -> None:
    """v = f / (mu m) with 1/m = (J M^-1 J^T)_yy: y_ddot = A M^-1 A^T f - mu y_dot, A y's row of J.

    What holds the others does not act along it: A C = 0.
    """
    fleet = PushedFleet(wire, arm=arm, friction="none")
    fleet.enable()
    fleet.comply("fy")
    fleet.move()
    fleet.run(150)
    before = fleet.force.complied[1]
    fleet.run(50)
    creep = fleet.force.complied[1] - before
    fleet.push = (0.0, newton, 0.0, 0.0, 0.0, 0.0)
    fleet.run(100)
    before = fleet.force.complied[1]
    fleet.run(50)
    speed = (fleet.force.complied[1] - before - creep) / (50 * 0.004)
    model = fleet.master.rows.newest
    mass = 1.0 / float((model.J @ np.linalg.solve(model.M, model.J.T))[1, 1])
    print(f"{arm}: {mass:.2f} kg, {1e3 * speed / newton:.2f} mm/s per newton")
    assert speed == pytest.approx(newton / (COMPLIANT_DAMPING * mass), rel=0.05)
