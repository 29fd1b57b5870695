"""A planner run through a task, and what each of its cycles cost."""

import gc
import time
from typing import Final

import numpy as np
from numpy.typing import NDArray

from planners.planner import Method, NotPossibleError
from planners.task import Task
from rfms_can.errors import RfmsError
from rfms_can.kinematics import Joints

Floats = NDArray[np.float64]

REST_CYCLES: Final = 12
"""Cycles run after the last goal is reached: what a motion ends with is then in the differences."""

LONGEST: Final = 3.0
"""Times the sum of its segments after which a motion that has not arrived never will."""


class Run:
    """One motion. Row k is time (k + 1) ``period_s`` of the task.

    Attributes:
        q: joint angles, rad, (N, 6).
        leg: which leg each row is on, (N,); the number of legs once the last goal is reached.
        blending: whether in a transition, (N,).
        costs_us: of each set-point, (N,).
        prepared_ms: what came before the first.
    """

    def __init__(self, method: Method, task: Task, period_s: float) -> None:
        """Run it.

        Raises:
            NotPossibleError: the planner cannot do the task.
        """
        self.task: Final = task
        self.period_s: Final = period_s
        q: list[Joints] = []
        self._leg: Final[list[int]] = []
        self._blending: Final[list[bool]] = []
        self._costs: Final[list[int]] = []
        collecting = gc.isenabled()
        gc.disable()  # its pauses are the process', not the planner's
        try:
            self._run(method, q)
        except NotPossibleError:
            raise
        except RfmsError as error:
            raise NotPossibleError(str(error)) from error
        finally:
            if collecting:
                gc.enable()
        self.q: Final[Floats] = np.array(q)
        self.leg: Final = np.array(self._leg)
        self.blending: Final = np.array(self._blending)
        self.costs_us: Final[Floats] = np.array(self._costs) / 1e3

    def _run(self, method: Method, q: list[Joints]) -> None:
        task, clock = self.task, time.perf_counter_ns
        began = clock()
        planner = method(task, self.period_s)
        self.prepared_ms = (clock() - began) / 1e6
        legs = len(task.legs)
        most = LONGEST * sum(leg.segment_time for leg in task.legs) / self.period_s
        after = REST_CYCLES + round(task.follow_time / self.period_s)
        while after:
            began = clock()
            angles = planner.step()
            self._costs.append(clock() - began)
            q.append(angles)
            self._leg.append(planner.leg)
            self._blending.append(planner.blending)
            after -= planner.leg == legs
            if len(q) > most + after:
                raise NotPossibleError("does not arrive")

    @property
    def time(self) -> Floats:
        """Of each row, s."""
        times: Floats = self.period_s * np.arange(1.0, len(self.q) + 1.0, dtype=np.float64)
        return times

    @property
    def arrival(self) -> float:
        """When the last goal is reached, s."""
        first = int(np.argmax(self.leg == len(self.task.legs)))
        return (first + 1) * self.period_s
