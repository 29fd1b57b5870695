"""The bench's tasks, and the order of continuity of a method, for the tests of planners."""

import math

from planners.bench import FINE_PERIODS
from planners.planner import Method
from planners.run import Run
from planners.smoothness import continuity
from planners.task import TASKS, Leg, Task

from rfms_can.arm import PUMA_260
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode

TAU = 0.004
CORNER, PICK, BELT = (TASKS[name](PUMA_260) for name in ("corner", "pick", "belt"))


def order(method: Method, task: Task) -> int:
    coarse, fine = (Run(method, task, period) for period in FINE_PERIODS)
    return continuity(coarse, fine)


def straight(*legs: tuple[float, float, float, float], mode: Mode = Mode.CARTESIAN) -> Task:
    """Legs of the corner task: metres in the base frame, and a turn in degrees about one axis."""
    place = CORNER.before(0, 0.0)
    made = []
    for x, y, z, degrees in legs:
        turn = Transform.rotation((0.6, 0.0, 0.8), math.radians(degrees))
        made.append(Leg(Transform.translation(x, y, z) @ place @ turn, mode, 0.9, 0.2))
    return Task("straight", CORNER.arm, CORNER.start, CORNER.tool, tuple(made))
