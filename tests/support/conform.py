"""The conformance suite on nodes of this process."""

from collections.abc import Callable, Iterable
from functools import cache

from rfms_can.conform.lines import Line, PumpedLine, SimulatedLine
from rfms_can.conform.outcome import Outcome, Verdict
from rfms_can.conform.runner import run_checks
from rfms_can.conform.table import CHECKS, Check
from rfms_can.conform.tester import Tester
from rfms_can.conform.vectors import Vectors
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.node.protocol import Node
from rfms_can.wire.contract import Wire


@cache
def the_wire() -> Wire:
    """One for all."""
    return Wire()


def make(joint: int) -> Callable[[], Node]:
    """Makes our node of a joint."""
    return lambda: JointNode(joint, the_wire(), 0x100 + joint)


def on_line(joint: int, line: Line, checks: Iterable[Check] = CHECKS) -> list[Outcome]:
    """The suite on a line."""
    return list(run_checks(Tester(line, joint, the_wire(), Vectors()), checks))


def pumped(joint: int, node: Callable[[], Node] | None = None) -> list[Outcome]:
    """The suite on a node that is called directly, by default ours."""
    return on_line(joint, PumpedLine(node or make(joint)))


def simulated(joint: int) -> list[Outcome]:
    """The suite on our node on the simulated bus."""
    return on_line(joint, SimulatedLine(make(joint)))


def failures(outcomes: Iterable[Outcome]) -> list[str]:
    """Required checks that failed, with what came and what was required."""
    return [
        f"{o.id} {o.title}: sent {o.sent}; got {o.got}; want {o.want}"
        for o in outcomes
        if o.verdict is Verdict.FAILED and o.required
    ]
