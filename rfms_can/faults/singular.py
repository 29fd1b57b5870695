"""Ways into a singular pose: a line that a program asks for, and a goal that moves by itself.

The arm stands before a straight wrist (``State.AT_WRIST``). The way to the other side passes the
singularity at a distance that is drawn: the nearer, the faster joints 4 and 6 would have to turn.
"""

import contextlib
import math
from typing import Final

from rfms_can.arm import Arm
from rfms_can.coordinator import Arm as Program
from rfms_can.errors import RfmsError
from rfms_can.faults.site import Site
from rfms_can.kinematics import Joints, configuration_of, direct
from rfms_can.transform import Transform

BEFORE_RAD: Final = 0.3
"""Angle of joint 5 on either side, rad."""
PART: Final = "part"
FOLLOW: Final = "follow"
_BEYOND: Final = "beyond"
_LINE: Final = "line"
NEAR: Final = (0.01, 0.03)
"""Distance from the singularity, rad, of a way that no joint limit allows."""
AWAY: Final = (0.06, 0.15)
"""The same of a way that can be taken slowly."""
FAST_S: Final = 0.6
"""Segment time that is asked for, s: half a second for the way, were the wrist not straight."""
LONGER: Final = 20.0
"""How many times longer a line may be made."""
LEADS: Final = (0.2, 0.6)
"""Speed of the goal that moves by itself, rad/s of joint 5."""
EVERY: Final = 5
"""Cycles between two observations of it."""
_X: Final = (1.0, 0.0, 0.0)


def _angles(arm: Arm, theta5: float) -> Joints:
    """Parked, but for the wrist: joint 4 has room to turn by half a turn, upwards."""
    q1, q2, q3, _, _, q6 = arm.park
    theta4 = 0.5 * (sum(arm.joint_limits[3]) - math.pi)
    return (q1, q2, q3, theta4, theta5, q6)


def pose(arm: Arm, theta5: float, away: float) -> Transform:
    """A pose before, in or beyond a straight wrist, turned about its x axis.

    Args:
        arm: the arm's data.
        theta5: rad; with 0 the wrist is straight.
        away: turn, rad: so far from the singularity the way passes.
    """
    return direct(arm, _angles(arm, theta5)) @ Transform.rotation(_X, away)


def stand_before(program: Program, arm: Arm) -> None:
    """Take an arm that is enabled there; it holds a goal that an observation moves."""
    start = pose(arm, -BEFORE_RAD, 0.0)
    program.mode(FOLLOW, segment_time=2.0, acceleration_time=0.3, lengthen=True)
    part = program.reference(PART, start)
    configuration = str(configuration_of(arm, _angles(arm, -BEFORE_RAD)))
    program.position(PART, program.t6 == part, config=configuration)
    program.wait(program.move(PART, FOLLOW))


def _away(site: Site, bounds: tuple[float, float]) -> float:
    """A distance from the singularity, rad, on the side on which joint 4 turns up."""
    return -site.context.draw.uniform(*bounds)


def _ask(site: Site, bounds: tuple[float, float], *, longer: bool) -> float:
    """Ask for a straight line to the other side; how far from the singularity it passes, rad."""
    arm, program = site.context.arm, site.program
    away = _away(site, bounds)
    program.mode(
        _LINE,
        segment_time=FAST_S,
        acceleration_time=FAST_S / 3.0,
        interpolation="cartesian",
        lengthen=longer,
        lengthen_at_most=LONGER,
    )
    goal = program.transform(_BEYOND, pose(arm, BEFORE_RAD, away))
    program.move(program.position(_BEYOND, program.t6 == goal), _LINE)
    return away


def line(site: Site) -> None:
    """A straight line past the singularity, too near and too fast for any joint."""
    _ask(site, NEAR, longer=False)


def slow_line(site: Site) -> None:
    """A line that may take longer; its effect is that the wrist comes near the singularity."""
    away = _ask(site, AWAY, longer=True)
    physics = site.rig.plant.physics
    site.touch_when(lambda: abs(physics.true_q[4]) < 2.0 * abs(away))


def led(site: Site) -> None:
    """The goal that the arm holds moves to the other side, whatever the arm can follow.

    The effect is the first cycle in which a joint is commanded beyond its speed limit.
    """
    context, program = site.context, site.program
    away, speed = _away(site, NEAR), context.draw.uniform(*LEADS)
    begun_ns, every_ns = context.now_ns(), EVERY * context.period_ns
    commanded = site.rig.master.motion.commanded
    limits = context.arm.speed_limits

    def lead() -> None:
        along = speed * (context.now_ns() - begun_ns) * 1e-9
        theta5 = min(BEFORE_RAD, along - BEFORE_RAD)
        turned = away * math.sin(min(1.0, along / BEFORE_RAD) * math.pi / 2.0)
        with contextlib.suppress(RfmsError):  # it stopped short: a sensor goes on all the same
            program.observe(PART, pose(context.arm, theta5, turned))
        site.later(every_ns, lead)

    lead()
    site.touch_when(
        lambda: any(abs(v) > limit for v, limit in zip(commanded.rate, limits, strict=True))
    )
