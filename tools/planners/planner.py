"""What every planner of the bench is: one set-point of six joints a cycle, and where it is."""

from collections.abc import Callable
from typing import Protocol

from planners.task import Task
from rfms_can.errors import RfmsError
from rfms_can.kinematics import Joints


class NotPossibleError(RfmsError):
    """The planner's method cannot do this task; the message is the reason."""


class Planner(Protocol):
    """A motion of all legs of a task, one cycle after the other.

    Attributes:
        leg: which leg the last set-point was on, from 0; the number of legs once the last goal is
            reached. From then on the planner stays there, or follows it.
        blending: whether it was in a transition into a leg, or to rest.
    """

    leg: int
    blending: bool

    def step(self) -> Joints:
        """The set-points of the next cycle, rad. Cycle 0 is one period after the task's time 0.

        Raises:
            NotPossibleError: the motion cannot be gone on with.
            KinematicsError: a pose has no solution.
        """


Method = Callable[[Task, float], Planner]
"""Prepares the motion of a task, for a period in seconds; raises ``NotPossibleError``."""
