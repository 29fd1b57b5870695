"""What a joint's motion and its motor say against it: asked by the controller, told to the ladder.

Each question counts its fault, or lets it trip, and says whether the torque had to change by it.
"""

from collections.abc import Mapping
from typing import Final

from rfms_can.joint_nodes.detectors.drive import OverloadWatch, StallWatch
from rfms_can.joint_nodes.detectors.following import Excess, FollowingWatch
from rfms_can.joint_nodes.detectors.runaway import RunawayWatch
from rfms_can.joint_nodes.field_node import Cause, FieldNode
from rfms_can.joint_nodes.ladder import Reaction, rung
from rfms_can.wire.records import Measure
from rfms_can.wire.vocabulary import FaultCode, Parameter

_FOLLOWING_ERROR: Final = FaultCode.FOLLOWING_ERROR


class MotionWatch:
    """Of one joint.

    Args:
        node: the bus life it belongs to.
        parameters: its configuration.

    Attributes:
        runaway, following, stall, overload: the watches.
    """

    __slots__ = (
        "_node",
        "_own",
        "_period",
        "_stall_s",
        "following",
        "overload",
        "runaway",
        "stall",
    )

    def __init__(self, node: FieldNode, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        self._node = node
        self._own = Cause(node.number, node.wire.id(Measure, node.number))
        self._period = p[Parameter.PERIOD]
        self._stall_s = p[Parameter.STALL_TIME]
        self.runaway = RunawayWatch(p, rung(FaultCode.RUNAWAY, Reaction.OFF))
        self.following = FollowingWatch(p)
        self.stall, self.overload = StallWatch(p), OverloadWatch(p)

    def begin_stop(self, speed: float) -> None:
        """A controlled stop begins at a measured speed, rad/s."""
        self.following.begin_stop(speed)
        self.runaway.reset()

    def comply(self) -> None:
        """A joint that complies need not follow."""
        self._node.ladder.clear(_FOLLOWING_ERROR)

    def runs_away(self, error: float, angle: float) -> bool:
        """Take a rigid joint's error and angle, rad; whether its torque had to go off (R4)."""
        if not self.runaway.watch(error, angle):
            return False
        self._node.trip(FaultCode.RUNAWAY, self._own._replace(bound=self.runaway.bound), error)
        return True

    def strays_servoing(self, error: float, rate: float) -> bool:
        """Take a rigid joint's error, rad, and its rate, rad/s; whether that stopped it (R4)."""
        return self._strays(self.following.servoing(error, rate))

    def strays_stopping(self, error: float, speed: float) -> bool:
        """Take the error against the stop's ramp, rad, and the joint's speed, rad/s; the same."""
        return self._strays(self.following.stopping(error, speed))

    def _strays(self, excess: Excess | None) -> bool:
        node = self._node
        if excess is None:
            node.ladder.clear(_FOLLOWING_ERROR)
            return False
        before = node.reaction
        node.miss(_FOLLOWING_ERROR, self._own._replace(bound=excess.bound), excess.value)
        return node.reaction is not before

    def push(self, cut: bool, speed: float) -> None:
        """Take a torque: whether it was cut to the limit, and the joint's speed, rad/s (R3)."""
        stall = self.stall
        if stall.stalls(cut, speed):
            cause = self._own._replace(bound=self._stall_s)
            self._node.trip(FaultCode.STALL, cause, stall.run * self._period)

    def bear(self, torque: float) -> None:
        """Take the torque of the cycle that is over, Nm (R3)."""
        overload = self.overload
        if not overload.bears(torque):
            cause = self._own._replace(bound=overload.bound)
            self._node.trip(FaultCode.OVERLOAD, cause, overload.heat)
