"""One corner planned with a deviation, run by generator and joints, and beside today's transition.

What is measured is what the joints do: the generator's set-points, rounded to float32 as on the
wire, through six joints as the nodes have them. Between two cycles the tool is where the cubic
through four places is.
"""

import struct
from typing import Final, NamedTuple

import numpy as np

from corners.draw import Corner, Floats, How, distance
from rfms_can.errors import RfmsError
from rfms_can.kinematics import Joints, JointSolver, direct
from rfms_can.master.trajectory.generator import TrajectoryGenerator
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.planning import MovePlanner, Plan
from rfms_can.master.trajectory.planning.corner import longest
from rfms_can.master.trajectory.segment import Move, Transition
from rfms_can.setpoint import CartesianSetpoint, JointSetpoint
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode

LONGEST: Final = 20000
"""Cycles of a run at most."""

LONGEST_ACCELERATION: Final = 1.0
"""Acceleration time up to which one is looked for that deviates as much, s."""

FINE: Final = 16
"""Places of the tool between two cycles that are looked at."""


class Result(NamedTuple):
    """What came of a corner; metres, seconds, radians.

    Attributes:
        arm, seed: which.
        modes: of the two legs, the transition between them: ``cartesian joint cartesian``.
        angle: of the corner.
        refused: why the move was not accepted; empty if it was.
        promised: the deviation answered.
        measured: what the joints made of it.
        acceleration_time: chosen for the corner.
        limited: whether a longer one would have had no room.
        segment_time: of the second leg; ``asked`` by its speed.
        today_deviation, today: deviation and segment time of the transition without a bound that
            deviates as much or, in whole periods, a little less; None if all are refused.
        peak: largest part of a joint's acceleration limit in the run.
    """

    arm: str
    seed: int
    modes: str
    angle: float
    refused: str = ""
    promised: float | None = None
    measured: float | None = None
    acceleration_time: float | None = None
    limited: bool = False
    segment_time: float | None = None
    asked: float | None = None
    today_deviation: float | None = None
    today: float | None = None
    peak: float | None = None


class Run:
    """A planner, a generator and six joints of an arm, at rest where a corner starts."""

    def __init__(self, corner: Corner, period_s: float) -> None:
        arm = corner.arm
        self.corner: Final = corner
        self.period_s: Final = period_s
        self.planner: Final = MovePlanner(arm, period_s)
        self.planner.reset(corner.start)
        self.generator: Final = TrajectoryGenerator(period_s)
        self.generator.enable(direct(arm, corner.start), corner.places[0].configuration)
        self._joints: Final = [
            (JointSetpoint(period_s, theta), JointSolver(arm, number))
            for number, theta in enumerate(corner.start, 1)
        ]
        self.moves: list[Move] = []

    def go(self, leg: int, how: How) -> Plan:
        """Plan a leg and request it."""
        generator, place = self.generator, self.corner.places[leg]
        plan = self.planner.plan(generator.entry, place, how, leg + 1)
        generator.request(*plan.moves)
        self.moves += plan.moves
        return plan

    def finish(self) -> Floats:
        """Angles of each cycle until the arm rests; shape (n, 6)."""
        rows: list[list[float]] = [list(self.corner.start)]
        for _ in range(LONGEST):
            setpoint = over_the_wire(self.generator.tick())
            rows.append([joint.tick(setpoint, solver.solve) for joint, solver in self._joints])
            if self.generator.at_rest and self.generator.completed == len(self.corner.places):
                return np.array(rows)
        raise AssertionError(f"seed {self.corner.seed}: not at rest after {LONGEST} cycles")


def result_of(corner: Corner, bound: float, period_s: float) -> Result:
    """Plan ``corner`` with a deviation of at most ``bound``, m, and run it."""
    first, second = corner.modes
    run = Run(corner, period_s)
    words = (first.mode.name, second.transition.name, second.mode.name)
    told = Result(corner.arm.name, corner.seed, " ".join(words).lower(), corner.angle)
    run.go(0, first)
    try:
        plan = run.go(1, second._replace(deviation=bound))
    except RfmsError as error:
        return told._replace(refused=str(error))
    if plan.via_deviation is None:
        raise AssertionError(f"seed {corner.seed}: nothing is passed")
    angles = run.finish()
    move = run.moves[1]
    before = today(corner, plan.via_deviation, period_s)
    return told._replace(
        promised=plan.via_deviation,
        measured=measured(corner, angles),
        acceleration_time=move.acceleration_ticks * period_s,
        limited=_limited(run.moves[0], move),
        segment_time=plan.segment_time,
        asked=distance(corner, 1) / second.speed,
        today_deviation=before[0],
        today=before[1],
        peak=peak(corner, angles, period_s),
    )


def _limited(before: Move, move: Move) -> bool:
    """Whether the segments have no room for one period more."""
    own = move.segment_ticks - move.rest_ticks - move.told_ticks - 2
    most = min(own, max(move.rest_ticks, move.segment_ticks // 2), longest(before, move))
    return move.acceleration_ticks >= most


def today(corner: Corner, bound: float, period_s: float) -> tuple[float | None, float | None]:
    """Deviation and segment time without a bound, by the acceleration time that keeps ``bound``.

    The longest of whole periods that does; its segment as short as it may be. The transition is
    Cartesian where it was so before bounds: between straight lines.
    """
    first, second = corner.modes
    straight = first.mode is Mode.CARTESIAN and second.mode is Mode.CARTESIAN
    transition = second.transition if straight else Transition.JOINT

    def plan(ticks: int) -> Plan | None:
        run = Run(corner, period_s)
        run.go(0, first)
        how = second._replace(transition=transition, acceleration_time=ticks * period_s)
        try:
            return run.go(1, how)
        except RfmsError:
            return None

    kept: Plan | None = None
    ticks = 1
    while ticks * period_s <= LONGEST_ACCELERATION:
        tried = plan(ticks)
        if tried is not None and tried.via_deviation is not None:
            if tried.via_deviation > bound * (1.0 + 1e-6):
                break
            kept = tried
        ticks += 1
    return (None, None) if kept is None else (kept.via_deviation, kept.segment_time)


def measured(corner: Corner, angles: Floats) -> float:
    """Smallest distance from the position that is passed to the way of the tool, m."""
    via = np.array(_point(corner.places[0].goal.left(Moment(0))))
    points = np.array([_point(_hand(corner, row) @ corner.tool) for row in angles.tolist()]) - via
    a, b, c, d = points[:-3], points[1:-2], points[2:-1], points[3:]
    distances = [np.linalg.norm(points, axis=1).min()]
    for x in np.arange(1, FINE) / FINE:
        place = (
            b * (1.0 + x) * (1.0 - x) * (2.0 - x) / 2.0
            + c * (1.0 + x) * x * (2.0 - x) / 2.0
            - a * x * (1.0 - x) * (2.0 - x) / 6.0
            - d * (1.0 + x) * x * (1.0 - x) / 6.0
        )
        distances.append(np.linalg.norm(place, axis=1).min())
    return float(min(distances))


def peak(corner: Corner, angles: Floats, period_s: float) -> float:
    """Largest second difference quotient of a joint, as part of its acceleration limit."""
    accelerations = np.abs(np.diff(angles, n=2, axis=0)) / period_s**2
    return float((accelerations / corner.arm.acceleration_limits).max())


def over_the_wire(setpoint: CartesianSetpoint) -> CartesianSetpoint:
    """``setpoint`` as a node hears it: o, a, p, r, p and t_acc rounded to float32."""
    second = setpoint.T6_2
    return setpoint._replace(
        T6_1=_rounded_pose(setpoint.T6_1),
        T6_2=None if second is None else _rounded_pose(second),
        r=_rounded(setpoint.r),
        p=_rounded(setpoint.p),
        acceleration_time=_rounded(setpoint.acceleration_time),
    )


def _rounded(value: float) -> float:
    return float(struct.unpack("f", struct.pack("f", value))[0])


def _rounded_pose(pose: Transform) -> Transform:
    e = [_rounded(element) for element in pose]
    return Transform.from_o_a_p((e[1], e[5], e[9]), (e[2], e[6], e[10]), (e[3], e[7], e[11]))


def _hand(corner: Corner, row: list[float]) -> Transform:
    q1, q2, q3, q4, q5, q6 = row
    q: Joints = (q1, q2, q3, q4, q5, q6)
    return direct(corner.arm, q)


def _point(pose: Transform) -> tuple[float, float, float]:
    return (pose.px, pose.py, pose.pz)
