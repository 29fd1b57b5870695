"""Whole cycles of joint 3, byte by byte: pose to ERROR to DAC; an encoder that jumps."""

from typing import Final

from generated import table

from node_book.printed import number
from node_book.pump import JOINT, Pump
from rfms_can.joint_nodes.servo import ServoTerms
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import JointError, Rows
from rfms_can.wire.vocabulary import Law, NodeState

LAW_ROW: Final = (0.1, -0.25, 1.0, 0.0, 0.125, 0.0)
INERTIA_ROW: Final = (0.0, 0.25, 0.5, 0.0, 0.0, 0.0)
GRAVITY: Final = 0.83
OTHERS: Final = {
    1: (0.002, 0.01, 0.5),
    2: (-0.003, 0.02, 1.0),
    4: (0.0, 0.0, 0.0),
    5: (0.001, 0.04, 0.0),
    6: (0.0, 0.0, 0.0),
}
BYTES_A_LINE: Final = 16
MOVED: Final = 2e-5
"""How far the set-point of each joint has gone in the cycle, rad."""


def whole_cycle() -> str:
    """SYNC, SETPOINT_1, MEASURE, six ERRORs and DAC, twice, ROWS between: none of them cut.

    The arm complies in the second: its law row is not its own alone."""
    pump = Pump().started()
    terms: list[ServoTerms] = []
    pump.node.record_terms(lambda _cycle, told: terms.append(told))
    since = len(pump.passed)
    pump.run()
    rest = (GRAVITY, 1, Law.PID, 0.0, 1, 1)
    pump.say(Rows, JOINT, *LAW_ROW, *INERTIA_ROW, *rest)
    pump.sync(NodeState.OPERATIONAL, 1)
    pump.shift(MOVED)
    pump.setpoint()
    pump.shift(-MOVED)
    pump.measure(off=3, speed_code=-40)
    for joint in JOINTS:
        if joint != JOINT:
            pump.say(JointError, joint, *OTHERS[joint], pump.low)
    lines = []
    for frame, from_node in pump.passed[since:]:
        head = f"{'node ->' if from_node else '-> node'}  {frame.id:03X}  [{len(frame.data):02d}]  "
        for begin in range(0, len(frame.data), BYTES_A_LINE):
            lines.append(head + frame.data[begin : begin + BYTES_A_LINE].hex(" ").upper())
            head = " " * len(head)
    controller = pump.node.controller
    assert controller is not None
    made = {
        "theta as measured": controller.sensing.theta,
        "set-point": controller.trajectory.theta,
        "its rate": controller.trajectory.rate,
        "its acceleration": controller.trajectory.acceleration,
        **{name: value for name, value in terms[-1]._asdict().items() if value},
        "torque": controller.torque,
    }
    rows = [(name, number(value, 9)) for name, value in made.items()]
    return "\n".join(["```", *lines, "```", "", table(("of the joint", "value"), rows)])


def glitches() -> str:
    """Samples that jump: two are bridged, the third stops the joint; one that does not, between."""
    pump = Pump().enabled()
    node = pump.node
    controller = node.controller
    assert controller is not None
    rows = []
    for off, speed_code in (
        (-4, -100),
        (-9, -100),
        (300, -100),
        (-19, -100),
        (300, 0),
        (420, 0),
        (540, 0),
        (540, 0),
    ):
        pump.sync(NodeState.OPERATIONAL)
        pump.setpoint()
        counts = pump.counts + off
        pump.measure(off=off, speed_code=speed_code)
        pump.other_errors()
        count = node.ladder.misses[7]
        told = (str(pump.cycle), str(counts), str(speed_code))
        made = (number(controller.sensing.theta, 9), str(count), node.state.name)
        rows.append((*told, *made))
    columns = ("cycle", "counts", "velocity_adc", "θ taken", "ENCODER_GLITCH", "state")
    return table(columns, rows)
