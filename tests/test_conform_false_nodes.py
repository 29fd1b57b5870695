"""Nodes that are wrong in one place fail the check that is about it."""

from collections.abc import Callable, Sequence
from typing import Any

import pytest
from support.conform import on_line, the_wire

from rfms_can.conform.checks import timing
from rfms_can.conform.lines import PumpedLine
from rfms_can.conform.outcome import Verdict
from rfms_can.conform.table import CHECKS
from rfms_can.conform.vectors import set_hash
from rfms_can.joint_nodes import field_node, sensing, servo
from rfms_can.joint_nodes.angle_solver import AngleSolver
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.controller import JointController
from rfms_can.joint_nodes.detectors import setpoint_step
from rfms_can.joint_nodes.detectors.bus import SyncNumbers
from rfms_can.joint_nodes.detectors.drive import AmplifierWatch, OverloadWatch, StallWatch
from rfms_can.joint_nodes.detectors.following import FollowingWatch
from rfms_can.joint_nodes.detectors.plausible_rows import RowsWatch
from rfms_can.joint_nodes.detectors.sensors import SensorWatch
from rfms_can.joint_nodes.field_node import FieldNode
from rfms_can.joint_nodes.homing import Homing
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.joint_nodes.ladder import LADDERS, Reaction
from rfms_can.joint_nodes.stop_ramp import StopRamp
from rfms_can.node.encoder_reference import EncoderReference
from rfms_can.setpoint.joint import JointSetpoint
from rfms_can.wire.frame import Frame
from rfms_can.wire.protection import Receiver
from rfms_can.wire.records import Rows
from rfms_can.wire.vocabulary import FaultCode

Patch = pytest.MonkeyPatch


class Mute(JointNode):
    """Sends nothing."""

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        super().on_frame(frame, now_ns)
        return ()


class BadCrc(JointNode):
    """Its own frames have a wrong CRC."""

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        sent = super().on_frame(frame, now_ns)
        return [Frame(f.id, bytes((f.data[0] ^ 1, *f.data[1:]))) for f in sent]


def mirrored(patch: Patch) -> None:
    right = AngleSolver.__init__

    def init(self: AngleSolver, *arguments: Any) -> None:
        right(self, *arguments)
        solve = self.solve
        self.solve = lambda *given: -solve(*given)

    patch.setattr(AngleSolver, "__init__", init)


def any_counter(patch: Patch) -> None:
    patch.setattr(Receiver, "_is_taken_up", lambda *_: True)


def no_discard_of_others(patch: Patch) -> None:
    def receive(self: RowSets, rows: Rows) -> None:
        named = self.number
        self.activate(rows)
        self.number = named
        self._arrived = rows

    patch.setattr(RowSets, "receive", receive)


def missing_rung(patch: Patch) -> None:
    ladder = tuple(
        step for step in LADDERS[FaultCode.SETPOINT_MISSING] if step[1] is not Reaction.DAMP
    )
    patch.setitem(LADDERS, FaultCode.SETPOINT_MISSING, ladder)


def late_watchdog(patch: Patch) -> None:
    right = FieldNode._commit

    def commit(self: FieldNode, *arguments: Any) -> Any:
        status = right(self, *arguments)
        self._watch_ns *= 2
        return status

    patch.setattr(FieldNode, "_commit", commit)


def integral_never_cleared(patch: Patch) -> None:
    def reset(self: servo.ServoState) -> None:
        kept = getattr(self, "sums", [0.0] * 6)
        right(self)
        self.sums = kept

    right = servo.ServoState.reset
    patch.setattr(servo.ServoState, "reset", reset)


def stale_gravity(patch: Patch) -> None:
    def activate(self: RowSets, rows: Rows) -> None:
        gravity = self.gravity
        right(self, rows)
        self.gravity = gravity

    right = RowSets.activate
    patch.setattr(RowSets, "activate", activate)


def zero_off_by_one(patch: Patch) -> None:
    def find(self: EncoderReference, *arguments: Any) -> bool | None:
        found = right(self, *arguments)
        if found:
            assert self.zero_counts is not None
            self.zero_counts += 1
        return found

    right = EncoderReference.find
    patch.setattr(EncoderReference, "find", find)


def homing_backwards(patch: Patch) -> None:
    right = Homing.__init__

    def init(self: Homing, *arguments: Any) -> None:
        right(self, *arguments)
        self._speed = -self._speed

    patch.setattr(Homing, "__init__", init)


def stop_that_steps(patch: Patch) -> None:
    patch.setattr(StopRamp, "step", lambda self: setattr(self, "speed", 0.0))


def no_extrapolation(patch: Patch) -> None:
    patch.setattr(JointSetpoint, "miss", lambda self: self.theta)


def longer_hash(patch: Patch) -> None:
    patch.setattr(field_node, "configuration_hash", lambda values: set_hash(values) ^ 1)


def wide_steps(patch: Patch) -> None:
    patch.setattr(setpoint_step, "STEP_MARGIN", 3.0)
    patch.setattr(sensing, "STEP_MARGIN", 3.0)


def late(watch: type, name: str, bound: str) -> Callable[[Patch], None]:
    """A detector whose bound is three tenths too large."""

    def false(patch: Patch) -> None:
        right = watch.__init__  # type: ignore[misc]

        def init(self: Any, *arguments: Any) -> None:
            right(self, *arguments)
            setattr(self, bound, 1.3 * getattr(self, bound))

        patch.setattr(watch, "__init__", init)

    false.__name__ = f"late_{name}"
    return false


def stop_as_it_was_told(patch: Patch) -> None:
    """It begins where and as fast as it was commanded, wherever the joint is."""

    def begin(self: JointController, position: float, rate: float) -> None:
        right(self, position, rate)
        assert self.ramp is not None
        self.ramp.position, self.ramp.speed = position, rate

    right = JointController._begin_stop
    patch.setattr(JointController, "_begin_stop", begin)


def any_current(patch: Patch) -> None:
    patch.setattr(AmplifierWatch, "border", lambda *_: None)


def barrier_again(patch: Patch) -> None:
    right = FieldNode._commit

    def commit(self: FieldNode, *arguments: Any) -> Any:
        status = right(self, *arguments)
        self._again_ns = self._watch_ns
        return status

    patch.setattr(FieldNode, "_commit", commit)


def any_master(patch: Patch) -> None:
    patch.setattr(SyncNumbers, "is_foreign", lambda *_: False)


def blind(patch: Patch) -> None:
    """Neither what its encoder and its tachometer tell nor what it costs is compared."""
    patch.setattr(SensorWatch, "differ", lambda *_: False)
    patch.setattr(SensorWatch, "variation", lambda *_: 0.0)


WRONG: dict[str, Callable[[Patch], None]] = {
    "31": mirrored,
    "4": any_counter,
    "29b": no_discard_of_others,
    "35": missing_rung,
    "41": late_watchdog,
    "29": stale_gravity,
    "21": zero_off_by_one,
    "43b": homing_backwards,
    "43b, stops": stop_that_steps,
    "30": no_extrapolation,
    "12": longer_hash,
    "39": wide_steps,
    "39c": stop_as_it_was_told,
    "41c": barrier_again,
    "52": late(SensorWatch, "tachometer", "_bound"),
    "52b": late(SensorWatch, "variation", "variation_bound"),
    "52e": any_current,
    "52f": late(FollowingWatch, "following", "_rate_bound"),
    "52g": late(StallWatch, "stall", "bound"),
    "52h": late(OverloadWatch, "overload", "bound"),
    "52i": late(RowsWatch, "rows", "_gravity_step"),
    "52k": blind,
    "53c": any_master,
}
"""The check that must fail (and of what in it), and what is wrong."""


def failed_checks(node: type[JointNode]) -> list[str]:
    line = PumpedLine(lambda: node(3, the_wire(), 7))
    return [o.id for o in on_line(3, line) if o.verdict is Verdict.FAILED]


@pytest.mark.parametrize("check", WRONG)
def test_a_false_node_fails_the_check_that_is_about_it(
    check: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    WRONG[check](monkeypatch)
    identifier = check.partition(",")[0]
    line = PumpedLine(lambda: JointNode(3, the_wire(), 7))
    (outcome,) = on_line(3, line, [c for c in CHECKS if c.id == identifier])
    assert outcome.verdict is Verdict.FAILED
    assert outcome.sent and outcome.got and outcome.want
    assert outcome.got != outcome.want


def test_an_integral_that_is_never_cleared_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    integral_never_cleared(monkeypatch)
    assert {"29", "43b"} & set(failed_checks(JointNode))


def test_a_node_that_says_nothing_ends_the_suite_early() -> None:
    assert failed_checks(Mute) == ["1", "1b", "2"]


def test_a_wrong_crc_is_told() -> None:
    line = PumpedLine(lambda: BadCrc(3, the_wire(), 7))
    outcome = on_line(3, line, [c for c in CHECKS if c.id == "2"])[0]
    assert outcome.want == "a CRC that fits data and data ID"


class TimedLine(PumpedLine):
    """A CAN interface of its own time, on which each answer takes as long.

    Attributes:
        latency_ns: of an answer.
    """

    virtual = False
    settle_ns = 1
    latency_ns = 0

    def receive(self, until_ns: int) -> Frame | None:
        frame = super().receive(until_ns)
        self.now_ns += self.latency_ns if frame is not None else 0
        return frame


@pytest.mark.parametrize(
    ("latency_ns", "verdict"), [(600_000, Verdict.PASSED), (800_000, Verdict.FAILED)]
)
def test_answers_that_come_too_late_are_found(
    latency_ns: int, verdict: Verdict, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(timing, "CYCLES", 40)
    line = TimedLine(lambda: JointNode(3, the_wire(), 7))
    line.latency_ns = latency_ns
    (outcome,) = on_line(3, line, [c for c in CHECKS if c.id == "51"])
    assert outcome.verdict is verdict, outcome
