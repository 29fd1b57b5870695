"""How far the tool is from where a leg would have it.

A Cartesian leg asks for a straight line of the tool's origin, turning about one axis in step with
it. Where its goal moves, that line is in the goal's frame: from where the transition into the leg
ends (or its first cycle) to the goal. Distances are geometric: a planner may be early or late.
"""

import math
from typing import NamedTuple

from planners.run import Run
from rfms_can.kinematics import direct
from rfms_can.transform import DriveTransform, Transform
from rfms_can.wire.vocabulary import Mode


class Off(NamedTuple):
    """Distance of the tool's origin, m, and angle of its orientation, rad."""

    distance: float
    angle: float


class Deviation(NamedTuple):
    """Largest distances and angles of one run; None where there is nothing to compare with.

    Attributes:
        line: on Cartesian legs, outside transitions.
        corner: in transitions from rest, from a Cartesian leg or to rest, on a Cartesian leg:
            from the nearer of the lines that meet there.
        goal: from the last goal, once reached.
    """

    line: Off | None
    corner: Off | None
    goal: Off


class Line:
    """A straight line between two poses of the tool."""

    def __init__(self, start: Transform, goal: Transform) -> None:
        self._goal = goal
        self._drive = DriveTransform(goal.inverse() @ start)

    def off(self, tool: Transform) -> Off:
        """From the point of the line that is nearest to ``tool``."""
        there = self._goal.inverse() @ tool
        (x, y, z), place = self._drive.p, (there.px, there.py, there.pz)
        length = x * x + y * y + z * z
        along = (x * place[0] + y * place[1] + z * place[2]) / length if length else 0.0
        return apart(self._drive.at(min(1.0, max(0.0, along))), there)


def apart(one: Transform, other: Transform) -> Off:
    """Between two poses."""
    turn = DriveTransform(one.inverse() @ other)
    return Off(math.hypot(*turn.p), turn.psi)


def deviation(run: Run) -> Deviation:
    """Of the tool, over all of a run."""
    legs = run.task.legs
    tools = [_tool(run, row) for row in range(len(run.q))]
    straight: list[Off] = []
    corners: list[Off] = []
    there: list[Off] = []
    for row, tool in enumerate(tools):
        leg = int(run.leg[row])
        if leg == len(legs):
            there.append(apart(legs[-1].goal(_time(run, row)), tool))
        elif legs[leg].mode is Mode.CARTESIAN and not run.blending[row]:
            straight.append(_line(run, tools, leg, row).off(tool))
        elif run.blending[row] and _corner(run, leg):
            lines = [_line(run, tools, k, row) for k in (leg - 1, leg) if k >= 0]
            corners.append(min(line.off(tool) for line in lines))
    return Deviation(_worst(straight), _worst(corners), _worst(there) or Off(math.nan, math.nan))


def _corner(run: Run, leg: int) -> bool:
    """Whether lines meet where ``leg`` begins, and their goals rest."""
    around = run.task.legs[max(0, leg - 1) : leg + 1]
    return all(each.mode is Mode.CARTESIAN and not each.moves for each in around)


def _line(run: Run, tools: list[Transform], leg: int, row: int) -> Line:
    """The line of ``leg`` as it is at ``row``."""
    asked = run.task.legs[leg]
    now = _time(run, row)
    if not asked.moves:
        return Line(run.task.before(leg, now), asked.target)
    on_it = [k for k in range(len(tools)) if run.leg[k] == leg and not run.blending[k]]
    first = on_it[0]
    start = asked.goal(_time(run, first)).inverse() @ tools[first]
    goal = asked.goal(now)
    return Line(goal @ start, goal)


def _time(run: Run, row: int) -> float:
    return (row + 1) * run.period_s


def _tool(run: Run, row: int) -> Transform:
    return direct(run.task.arm, run.q[row].tolist()) @ run.task.tool


def _worst(offs: list[Off]) -> Off | None:
    if not offs:
        return None
    return Off(max(off.distance for off in offs), max(off.angle for off in offs))
