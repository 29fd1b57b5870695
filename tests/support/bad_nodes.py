"""Bad joint nodes: our own, tampered with by a thin wrapper, in a system that is whole otherwise.

``tampered`` changes what a node sends or hears, ``JointNode``'s subclasses what it computes. A bad
node takes the place of joint 3 in runs of ``rfms run`` on the simulated bus.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final

import pytest

from rfms_can.joint_nodes.controller import JointController
from rfms_can.joint_nodes.field_node import Cause, Parameters
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.kinematics import Configuration
from rfms_can.rig import simulated
from rfms_can.rig.nodes import make_joint
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import Sync
from rfms_can.wire.vocabulary import FaultCode

BAD: Final = 3
"""The joint that is bad."""

Make = Callable[[int, Wire, int], JointNode]
"""A node of a joint, wire and boot id."""
Begun = Callable[[SimulatedRig], None]
"""Told of a rig that has been made."""
Tamper = Callable[["Tampered", Frame], Iterable[Frame]]
"""What goes out, or comes in, instead of a frame."""


def as_it_is(_node: "Tampered", frame: Frame) -> Iterable[Frame]:
    """Nothing is changed."""
    return (frame,)


class Tampered(JointNode):
    """A joint whose frames are tampered with on their way out and in.

    Attributes:
        cycle_heard: number of the last SYNC.
        enabled: whether START has been taken.
    """

    def __init__(self, joint: int, wire: Wire, boot_id: int, out: Tamper, into: Tamper) -> None:
        super().__init__(joint, wire, boot_id)
        self._tamper, self._tamper_in = out, into
        self._senders_again: dict[int, Sender[Any]] = {}

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        out: list[Frame] = []
        for heard in self._tamper_in(self, frame):
            out += super().on_frame(heard, now_ns)
        return [sent for frame in out for sent in self._tamper(self, frame)]

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        return [sent for frame in super().on_time(now_ns) for sent in self._tamper(self, frame)]

    @property
    def enabled_cycles(self) -> int:
        """Cycles since START; -1 before."""
        return self.cycle if self.state.name == "OPERATIONAL" else -1

    def is_a(self, frame: Frame, record: type[Any], node: int | None = BAD) -> bool:
        """Whether a frame is of a message."""
        return frame.id == self.wire.id(record, node)

    def changed(self, frame: Frame, record: type[Any], **values: float) -> Frame:
        """The frame with other values, right CRC and right counter."""
        codec = self.wire.codec(record, BAD)
        old: Any = codec.unpack(frame.data)
        sender = self._senders_again.setdefault(frame.id, self.wire.sender(record, BAD))
        sender._buffer[2] = frame.data[2] - 1 & 0xFF
        return sender.frame(*old._replace(**values))


class Unwatched(Tampered):
    """The same, of a node that watches neither its board nor its motion itself."""

    BLIND = frozenset(
        (
            FaultCode.ADC_SATURATED,
            FaultCode.AMPLIFIER_FAULT,
            FaultCode.FOLLOWING_ERROR,
            FaultCode.OVERSPEED,
            FaultCode.SENSOR_MISMATCH,
            FaultCode.STALL,
        )
    )

    def _make_controller(self, parameters: Parameters) -> JointController:
        controller = super()._make_controller(parameters)
        controller.motion.runaway.bound = math.inf  # type: ignore[misc]  # a bad node
        return controller

    def miss(self, fault: FaultCode, cause: Cause, value: float | None = None) -> None:
        """Overlook what a board or a motion shows."""
        if fault not in self.BLIND:
            super().miss(fault, cause, value)

    def trip(self, fault: FaultCode, cause: Cause, value: float) -> None:
        """The same."""
        if fault not in self.BLIND:
            super().trip(fault, cause, value)


def tampered(
    out: Tamper = as_it_is, into: Tamper = as_it_is, kind: type[Tampered] = Tampered
) -> Make:
    """A joint whose frames are changed on their way."""
    return lambda joint, wire, boot_id: kind(joint, wire, boot_id, out, into)


def without(record: type[Any]) -> Make:
    """A joint that never sends a message."""
    return tampered(lambda node, frame: () if node.is_a(frame, record) else (frame,))


class Mirrored(JointNode):
    """A joint whose inverse solution has the wrong sign: it runs the other way."""

    def _make_controller(self, parameters: Parameters) -> JointController:
        controller = super()._make_controller(parameters)
        solve, first = controller._solver.solve, []

        def mirrored(pose: Transform, configuration: Configuration, previous: float) -> float:
            angle = solve(pose, configuration, previous)
            first.append(angle)
            return 2.0 * first[0] - angle

        controller._solver.solve = mirrored
        return controller


class OtherHash(JointNode):
    """A joint of another contract."""

    def __init__(self, joint: int, _wire: Wire, boot_id: int) -> None:
        other = Wire()
        other.dbc_hash ^= 0x0F00
        super().__init__(joint, other, boot_id)


def restarts(at: int) -> Make:
    """A joint that starts again in motion, with another boot id."""

    class Restarting(JointNode):
        fresh: JointNode | None = None

        def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
            if self.fresh is not None:
                return self.fresh.on_frame(frame, now_ns)
            if self.state.name == "OPERATIONAL" and self.cycle >= at and frame.id == SYNC:
                self.fresh = JointNode(self.number, self.wire, self.boot_id ^ 0xFFFF)
                return self.fresh.on_time(now_ns)
            return super().on_frame(frame, now_ns)

        def next_deadline_ns(self) -> int | None:
            if self.fresh is not None:
                return self.fresh.next_deadline_ns()
            return super().next_deadline_ns()

        def on_time(self, now_ns: int) -> Sequence[Frame]:
            if self.fresh is not None:
                return self.fresh.on_time(now_ns)
            return super().on_time(now_ns)

    return Restarting


SYNC: Final = Wire().id(Sync)


def replace_joint(
    monkeypatch: pytest.MonkeyPatch, make: Make, begun: Begun = lambda _: None
) -> None:
    """A bad node takes joint 3's place in every simulated rig from now on.

    Args:
        monkeypatch: undoes it.
        make: the bad node.
        begun: called with each rig.
    """
    begin = SimulatedRig.__init__

    def made(number: int, settings: RunSettings, wire: Wire) -> JointNode:
        if number != BAD:
            return make_joint(number, settings, wire)
        return make(number, wire, settings.boot_id(number))

    def noted(rig: SimulatedRig, *arguments: Any, **options: Any) -> None:
        begin(rig, *arguments, **options)
        begun(rig)

    monkeypatch.setattr(simulated, "make_joint", made)
    monkeypatch.setattr(SimulatedRig, "__init__", noted)
