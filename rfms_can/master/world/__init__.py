"""The world model: transforms of three kinds, position equations, modes (thesis VI.4.1, VI.4.3)."""

from rfms_can.master.world.model import WorldModel
from rfms_can.master.world.modes import Limits, MotionMode
from rfms_can.master.world.position import Position

__all__ = ["Limits", "MotionMode", "Position", "WorldModel"]
