"""Plays traces to our joint node and writes down what it does, in SI."""

from typing import Any

from conform_law_traces import Trace

from rfms_can.conform.lines import PumpedLine
from rfms_can.conform.play import AT_REST, ONCE, play
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.conform.vectors import Vectors
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.joint_nodes.servo import ServoTerms
from rfms_can.wire.contract import Wire
from rfms_can.wire.vocabulary import FaultCode

JOINT = 2
"""Any would do: traces are the same for all."""


def recorded(traces: list[Trace], *, torques: bool = True) -> list[Trace]:
    """The traces with what the node did in each cycle, with ``torques`` or without."""
    wire = Wire()
    nodes: list[JointNode] = []

    def make() -> JointNode:
        nodes.append(JointNode(JOINT, wire, 1))
        return nodes[-1]

    tester = Tester(PumpedLine(make), JOINT, wire, Vectors())
    tester.greet()
    return [_record(tester, nodes[-1], trace, torques) for trace in traces]


def _record(tester: Tester, node: JointNode, trace: Trace, torques: bool) -> Trace:
    terms = ServoTerms()

    def keep(_cycle: int, told: ServoTerms) -> None:
        nonlocal terms
        terms = told

    node.record_terms(keep)
    cycles: list[dict[str, Any]] = []
    before: dict[str, Any] = dict(AT_REST)
    sends = ["ERROR", "DAC"]
    state = None
    for cycle, (_, answers) in zip(trace["cycles"], play(tester, trace), strict=True):
        out: dict[str, Any] = {}
        now = [_name(h.name, h.values) for h in answers if h.name != "HEARTBEAT"]
        if now != sends:
            out["sends"] = sends = now
        out |= _outputs(answers, node, terms if torques else None)
        if state is not None and node.state is not state:
            out["becomes"] = node.state.name
        state = node.state
        cycles.append({**_changed(cycle, before), **out})
        before |= cycle
    return {**trace, "cycles": cycles}


def _changed(cycle: dict[str, Any], before: dict[str, Any]) -> dict[str, Any]:
    """The inputs that are not as they were."""
    nothing = object()
    return {k: v for k, v in cycle.items() if k in ONCE or v != before.get(k, nothing)}


def _name(name: str, values: Any) -> str:
    return f"EMCY {FaultCode(values.fault).name}" if name == "EMCY" else name


def _outputs(answers: Answers, node: JointNode, terms: ServoTerms | None) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for error in answers.of("ERROR"):
        out["error"] = [
            round(error.error, 9),
            round(error.error_rate, 6),
            round(error.acceleration, 4),
        ]
    if terms is not None and answers.of("DAC"):
        out["torque"] = _digits(node.torque - terms.bias)
        out["force"] = _digits(terms.bias)
    return out


def _digits(value: float) -> float:
    return float(f"{value:.9g}")
