"""A joint node and all that is around it, pumped with plain calls; every frame is kept."""

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.kinematics import configuration_of, direct
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.setpoint.frames import values_of
from rfms_can.wire.configuration import configuration_hash
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS, MASTER
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import (
    Config,
    Dac,
    Heartbeat,
    JointError,
    Measure,
    Nmt,
    Reference,
    Setpoint,
    Sync,
)
from rfms_can.wire.vocabulary import (
    Blend,
    Command,
    Mode,
    NodeState,
    Parameter,
    TrajectoryState,
)

JOINT: Final = 3
PERIOD_S: Final = 0.004
PERIOD_NS: Final = 4_000_000
POWER_UP_COUNTS: Final = 1234
"""Counts between joint angle 0 and the zero of the encoder at power-up."""


def parameters() -> dict[Parameter, float]:
    """The configuration of the pages' joint: joint 3 of the PUMA 260 at 250 Hz, as float32."""
    return all_parameters(PUMA_260, "corke", PERIOD_S)[JOINT]


class Passed(NamedTuple):
    """A frame that passed, and whether the node sent it."""

    frame: Frame
    from_node: bool


class Pump:
    """Speaks to joint 3 for master, plant and the other joints.

    Attributes:
        node: the joint.
        passed: all frames so far, in order.
        cycle: of the last SYNC.
    """

    def __init__(self) -> None:
        self.wire = Wire()
        self.node = JointNode(JOINT, self.wire, 0x5EED0003)
        self.passed: list[Passed] = []
        self.cycle = -1
        self._now_ns = 0
        self._asked = self._acting = self._driven = 0  # codes of current_dac, the last first
        self._q = list(PUMA_260.park)
        self._counts_per_rad = parameters()[Parameter.COUNTS_PER_UNIT]
        self._senders: dict[tuple[Any, int | None], Sender[Any]] = {}
        self._take(self.node.on_time(0))

    def say(self, record: type[NamedTuple], node: int | None, *values: float) -> list[Frame]:
        """Send a message; what the node answers."""
        key = (record, node)
        if key not in self._senders:
            self._senders[key] = self.wire.sender(record, node)
        frame = self._senders[key].frame(*values)
        self.passed.append(Passed(frame, False))
        return self._take(self.node.on_frame(frame, self._now_ns))

    def give(self, frame: Frame) -> list[Frame]:
        """Send a frame as it is."""
        self.passed.append(Passed(frame, False))
        return self._take(self.node.on_frame(frame, self._now_ns))

    def _take(self, frames: Sequence[Frame]) -> list[Frame]:
        self.passed += [Passed(frame, True) for frame in frames]
        for frame in frames:
            if frame.id == self.wire.id(Dac, JOINT):
                dac = self.wire.codec(Dac, JOINT).unpack(frame.data)
                assert dac is not None
                self._asked = dac.current_dac
        return list(frames)

    def reset_counters(self) -> None:
        """All senders begin at 0 again."""
        for sender in self._senders.values():
            sender.reset()

    # --- bring-up -----------------------------------------------------------------------------

    def introduce(self, boot_id: int = 0x0B007ED8) -> None:
        """The master tells that it is there."""
        values = (NodeState.PREOP, 0, 0, boot_id, self.wire.dbc_hash, 0, 0, 0)
        self.say(Heartbeat, MASTER, *values)

    def command(self, command: Command, node: int = 0, argument: int = 0) -> list[Frame]:
        """NMT; a START that is taken lets the counters begin at 0, as the master's does."""
        before = self.node.state
        answers = self.say(Nmt, None, command, node, argument)
        if self.node.state is NodeState.OPERATIONAL is not before:
            self.reset_counters()
            self.cycle = -1
        return answers

    def configure(self) -> None:
        """The whole dialogue."""
        values = dict(sorted(parameters().items()))
        for parameter, value in values.items():
            self.say(Config, JOINT, parameter, 0, value, 0)
        digest = configuration_hash(values)
        self.say(Config, JOINT, Parameter.COMMIT, len(values), 0.0, digest)

    # --- a cycle ------------------------------------------------------------------------------

    def shift(self, by: float) -> None:
        """The arm, or where it is wanted, is elsewhere by an angle in each joint, rad."""
        self._q = [q + by for q in self._q]

    def sync(self, state: NodeState, row_set: int = 0) -> list[Frame]:
        """The next cycle, a period later."""
        self.cycle += 1
        self._now_ns += PERIOD_NS
        self._driven, self._acting = self._acting, self._asked
        return self.say(Sync, None, self.cycle, state, row_set, self.wire.dbc_hash)

    def miss_sync(self) -> list[Frame]:
        """Let time pass until the node misses a SYNC."""
        due = self.node.next_deadline_ns()
        assert due is not None
        self._now_ns = due
        return self._take(self.node.on_time(due))

    @property
    def low(self) -> int:
        """Low byte of the cycle."""
        return self.cycle & 0xFF

    @property
    def counts(self) -> int:
        """Of the encoder, where the joint stands."""
        return round(self._q[JOINT - 1] * self._counts_per_rad) - POWER_UP_COUNTS

    def measure(self, braked: int = 0, off: int = 0, speed_code: int = 0) -> list[Frame]:
        """The board's sample where the joint stands, ``off`` by some counts; the current is that
        of the DAC of two cycles before."""
        told = (self.counts + off, self._driven, speed_code, self.low, 0, braked)
        return self.say(Measure, JOINT, *told)

    def reference(self) -> list[Frame]:
        """The index has been seen already."""
        p, angle = parameters(), self._q[JOINT - 1]
        interval = round(p[Parameter.INDEX_INTERVAL_COUNTS])
        pulse = round(angle * self._counts_per_rad) // interval * interval
        coarse = round((angle - p[Parameter.COARSE_ZERO]) / p[Parameter.COARSE_PER_CODE])
        return self.say(Reference, JOINT, coarse, pulse - POWER_UP_COUNTS, 1, self.low)

    def setpoint(self) -> list[Frame]:
        """SETPOINT_1 of an arm at rest."""
        pose, configuration = direct(PUMA_260, self._q), configuration_of(PUMA_260, self._q)
        setpoint = CartesianSetpoint(
            *(TrajectoryState.IDLE, Mode.JOINT, Blend.CONTINUOUS, 0.0, 0.0, 0.2),
            *(pose, configuration, None, configuration),
        )
        return self.say(Setpoint, 1, *values_of(setpoint, pose, configuration, self.cycle))

    def other_errors(self) -> list[Frame]:
        """ERROR of the five other joints; what the node answers to the last."""
        answers: list[Frame] = []
        for joint in JOINTS:
            if joint != JOINT:
                answers = self.say(JointError, joint, 0.0, 0.0, 0.0, self.low)
        return answers

    def home(self) -> None:
        """From PREOP to READY, in one cycle."""
        self.command(Command.HOME)
        self.sync(NodeState.HOMING)
        self.measure()
        self.reference()

    def run(self, cycles: int = 1) -> None:
        """Good control cycles."""
        for _ in range(cycles):
            self.sync(NodeState.OPERATIONAL)
            self.setpoint()
            self.measure()
            self.other_errors()

    def started(self) -> "Pump":
        """From power-up to OPERATIONAL."""
        self.introduce()
        self.configure()
        self.home()
        self.command(Command.START)
        return self

    def enabled(self) -> "Pump":
        """From power-up to OPERATIONAL, and through a cycle."""
        self.started()
        self.run()
        assert self.node.state is NodeState.OPERATIONAL
        return self
