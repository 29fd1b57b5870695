"""The third node, written from the handbook alone, and ours: they do the same, frame by frame."""

import ast
import random
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import make_conform_vectors
import pytest
from support.conform import failures, on_line, the_wire
from third_line import ThirdNode

from rfms_can.conform import tester as testing
from rfms_can.conform.lines import PumpedLine
from rfms_can.conform.table import CHECKS
from rfms_can.conform.vectors import Vectors
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.vocabulary import Command, NodeState

THIRD = Path(make_conform_vectors.__file__).parent / "third_node"
VECTORS = make_conform_vectors.VECTORS
SLOW = ("5", "8", "29", "30")
"""Checks that take most of the time: bits and ranges frame by frame, and the traces."""
QUICK = [check for check in CHECKS if check.id not in SLOW]


def test_it_imports_nothing_of_ours() -> None:
    """Nor anything but Python's own: what it computes, it computes itself."""
    allowed = {"third_node", "collections", "copy", "fractions", "math", "pathlib", "re", "struct"}
    files = sorted(THIRD.glob("*.py"))
    found = set()
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                found.add((node.module or ".").partition(".")[0])
    assert found - allowed - {"typing"} == set()
    assert files and not list(THIRD.rglob("*.dbc"))


@pytest.mark.parametrize("file", sorted(make_conform_vectors.FILES))
def test_the_vectors_are_those_it_makes(file: str) -> None:
    made = make_conform_vectors.text_of(make_conform_vectors.FILES[file]())
    kept = (VECTORS / f"{file}.json").read_text(encoding="utf-8")
    assert made == kept, "run python tools/make_conform_vectors.py"


@pytest.mark.system
@pytest.mark.parametrize("file", sorted(make_conform_vectors.TRACES))
def test_the_traces_are_those_it_makes(file: str) -> None:
    kept = (VECTORS / f"{file}.json").read_text(encoding="utf-8")
    assert make_conform_vectors.text_of(make_conform_vectors.traced(file)) == kept


@pytest.mark.system
@pytest.mark.parametrize("joint", [1, 4])
def test_it_passes_the_suite(joint: int) -> None:
    line = PumpedLine(lambda: ThirdNode(joint, 0x100 + joint))
    assert failures(on_line(joint, line)) == []


# --- both at once ---------------------------------------------------------------------------------


class Twins:
    """Our node and the third one: both hear all, and what they send must be the same.

    Args:
        joint: its number.
        wire: the contract.
    """

    def __init__(self, joint: int, wire: Wire) -> None:
        self.ours = JointNode(joint, wire, 0x100 + joint)
        self.third = ThirdNode(joint, 0x100 + joint)
        self.name = f"twins of joint {joint}"
        self.accepts = self.ours.accepts
        self._codecs = {codec.id: codec for codec in wire.codecs.values()}
        assert self.third.accepts == self.accepts

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        """Both hear it."""
        ours = self.ours.on_frame(frame, now_ns)
        self._compare(ours, self.third.on_frame(frame, now_ns), frame)
        return ours

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Both are due."""
        ours = self.ours.on_time(now_ns)
        self._compare(ours, self.third.on_time(now_ns), None)
        return ours

    def next_deadline_ns(self) -> int | None:
        """They wait for the same SYNC."""
        due = self.ours.next_deadline_ns()
        assert self.third.next_deadline_ns() == due
        return due

    def _compare(self, ours: Sequence[Frame], third: Sequence[Frame], cause: Frame | None) -> None:
        told = cause and self._codecs[cause.id].name
        mine, other = ([self._read(frame) for frame in frames] for frames in (ours, third))
        assert [name for name, _ in mine] == [name for name, _ in other], told
        for (name, own), (_, its) in zip(mine, other, strict=True):
            for field, a, b in zip(own._fields, own, its, strict=True):
                assert b == pytest.approx(a, abs=TOLERANCES.get(field, 0.0), rel=1e-5), (
                    f"{name} {field} after {told} in {self.ours.state.name}"
                )
        assert [f.data[2] for f in ours] == [f.data[2] for f in third], "counters"

    def _read(self, frame: Frame) -> tuple[str, Any]:
        codec = self._codecs[frame.id]
        return codec.name, codec.unpack(frame.data)


TOLERANCES = {
    "error": 1e-6,
    "error_rate": 1e-3,
    "acceleration": 0.1,
    "current_dac": 1,
    "force_dac": 1,
}
"""What docs/node.md asks for; all other fields are the same, floats to float32."""


@pytest.mark.parametrize("joint", [2, 5])
def test_in_every_check_of_the_suite_they_send_the_same(joint: int) -> None:
    line = PumpedLine(lambda: Twins(joint, the_wire()))
    assert failures(on_line(joint, line, QUICK)) == []


@pytest.mark.parametrize("seed", range(6))
def test_on_random_cycles_they_send_the_same(seed: int) -> None:
    """Commands, lost and late frames, jumps and gaps, in any order."""
    rng = random.Random(seed)
    joint = rng.randrange(1, 7)
    tester = testing.Tester(
        PumpedLine(lambda: Twins(joint, the_wire())), joint, the_wire(), Vectors()
    )
    tester.greet()
    for _ in range(8):
        tester.operational(theta=rng.uniform(-1.0, 1.0))
        speed = rng.uniform(-0.4, 0.4)
        set_point = tester.measured
        for _ in range(rng.randrange(5, 60)):
            set_point += speed * 0.004
            _random_cycle(rng, tester, set_point)
            if rng.random() < 0.03:
                tester.command(rng.choice(tuple(Command)))
            if rng.random() < 0.02:
                tester.elapse(rng.uniform(0.0, 0.03))


def _random_cycle(rng: random.Random, t: testing.Tester, set_point: float) -> None:
    """A cycle as it should be, most of the time."""
    usual = rng.random() < 0.8
    state = NodeState.OPERATIONAL if usual else rng.choice(tuple(NodeState))
    skip = 0 if rng.random() < 0.93 else rng.randrange(1, 5)
    t.sync(state, skip=skip, row_set=None if rng.random() < 0.95 else rng.randrange(1, 256))
    t.theta = set_point - rng.uniform(-0.002, 0.002)
    if rng.random() < 0.04:
        t.theta += rng.choice((-1.0, 1.0)) * rng.uniform(0.01, 0.3)
    t.speed = rng.uniform(-0.3, 0.3)
    parts: list[Callable[[], object]] = [
        *(t.measure, t.reference),
        *(lambda: t.setpoint(set_point), lambda: _errors(rng, t)),
    ]
    rng.shuffle(parts)
    for part in parts:
        if rng.random() < 0.94:
            part()
        if rng.random() < 0.02:
            part()
    if rng.random() < 0.1:
        law = [rng.uniform(-0.2, 1.0) for _ in range(6)]
        inertia = [rng.uniform(-0.05, 0.1) for _ in range(6)]
        rest = (rng.uniform(-1.0, 1.0), t.row_set % 255 + 1, rng.randrange(2))
        t.rows(int(rest[1]), (*law, *inertia, *rest, rng.uniform(0.0, 30.0), rng.randrange(64), 1))


def _errors(rng: random.Random, t: testing.Tester) -> object:
    values = [[rng.uniform(-0.01, 0.01), rng.uniform(-0.3, 0.3), 0.5] for _ in range(5)]
    return t.errors(values)
