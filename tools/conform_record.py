"""Plays traces to the third node and writes down what it does, in SI."""

from typing import Any

from conform_law_traces import Trace
from third_line import ThirdNode
from third_node import Node
from third_node.life import STATES

from rfms_can.conform.checks.tracing import TIMED
from rfms_can.conform.lines import PumpedLine
from rfms_can.conform.play import AT_REST, ONCE, play
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.conform.vectors import Vectors
from rfms_can.wire.contract import Wire
from rfms_can.wire.vocabulary import FaultCode

JOINT = 2
"""Any would do: traces are the same for all."""


def recorded(traces: list[Trace], *, torques: bool = True, registers: bool = False) -> list[Trace]:
    """The traces with what the node did in each cycle, with ``torques`` and ``registers`` or
    without."""
    wire = Wire()
    nodes: list[ThirdNode] = []

    def make() -> ThirdNode:
        nodes.append(ThirdNode(JOINT))
        return nodes[-1]

    tester = Tester(PumpedLine(make), JOINT, wire, Vectors())
    tester.greet()
    return [_record(tester, nodes[-1].node, trace, torques, registers) for trace in traces]


def _record(tester: Tester, node: Node, trace: Trace, torques: bool, registers: bool) -> Trace:
    cycles: list[dict[str, Any]] = []
    before: dict[str, Any] = dict(AT_REST)
    sends = ["ERROR", "DAC"]
    state = register = None
    for cycle, (_, answers) in zip(trace["cycles"], play(tester, trace), strict=True):
        out: dict[str, Any] = {}
        now = [_name(h.name, h.values) for h in answers if h.name != "HEARTBEAT"]
        if now != sends:
            out["sends"] = sends = now
        out |= _outputs(answers, node if torques else None)
        if state is not None and node.state != state:
            out["becomes"] = STATES[node.state]
        state = node.state
        if registers:
            told = tester.beat().error_register & ~TIMED
            if told != register:
                out["register"] = register = told
        cycles.append({**_changed(cycle, before), **out})
        before |= cycle
    return {**trace, "cycles": cycles}


def _changed(cycle: dict[str, Any], before: dict[str, Any]) -> dict[str, Any]:
    """The inputs that are not as they were."""
    nothing = object()
    return {k: v for k, v in cycle.items() if k in ONCE or v != before.get(k, nothing)}


def _name(name: str, values: Any) -> str:
    return f"EMCY {FaultCode(values.fault).name}" if name == "EMCY" else name


def _outputs(answers: Answers, node: Node | None) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for error in answers.of("ERROR"):
        out["error"] = [
            round(error.error, 9),
            round(error.error_rate, 6),
            round(error.acceleration, 4),
        ]
    if node is not None and answers.of("DAC"):
        out["torque"] = _digits(node.torque)
        out["force"] = _digits(node.sent_bias)
    return out


def _digits(value: float) -> float:
    return float(f"{value:.9g}")
