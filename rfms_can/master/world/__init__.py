"""The world model: transforms of three kinds, positions, modes (thesis VI.4.1, VI.4.3)."""

from rfms_can.master.world.joint_position import JointPosition
from rfms_can.master.world.model import AnyPosition, WorldModel
from rfms_can.master.world.modes import Limits, MotionMode
from rfms_can.master.world.position import Position

__all__ = ["AnyPosition", "JointPosition", "Limits", "MotionMode", "Position", "WorldModel"]
