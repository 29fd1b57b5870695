"""The rules a move must keep before the trajectory generator takes it (errata to Chapter III)."""

from math import pi
from typing import Final

from rfms_can.errors import MoveError
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.pace import LONGEST_ACCELERATION_S
from rfms_can.master.trajectory.segment import Move, Segment, Transition
from rfms_can.transform import DriveTransform
from rfms_can.wire.vocabulary import Mode

MAX_ROTATION: Final = 0.8 * pi
"""Largest psi of one Cartesian segment, rad (3.4.3): nearer to pi the axis is ill defined."""


def check_times(move: Move, period_s: float) -> None:
    """A move must leave room for its own transitions, in and to rest.

    Raises:
        MoveError: t_seg < 2 t_acc + 2 tau, or a time under one period.
    """
    name = f"move {move.sequence}"
    shortest = min(move.acceleration_ticks, move.rest_ticks)
    if shortest < 1:
        raise MoveError(
            f"{name}: acceleration time of {shortest} periods: give at least one ({period_s:g} s)"
        )
    least, longest = move.least_ticks, move.longest_entry
    if move.segment_ticks < least:
        raise MoveError(
            f"{name}: segment time {move.segment_ticks * period_s:.6g} s is under twice the "
            f"acceleration time plus two periods, {least * period_s:.6g} s: the arm could not "
            f"stop at the goal; lengthen the segment or shorten the acceleration time "
            f"({longest * period_s:.6g} s)"
        )


def check_succession(before: Move, move: Move, period_s: float) -> None:
    """The segment before must have room for both its transitions, in and on to ``move``.

    Raises:
        MoveError: t_seg(before) < t_acc(before) + t_acc(move) + 2 tau. The segment before is
            promised already, so it is ``move`` that is refused.
    """
    longest = before.room
    if move.acceleration_ticks > longest:
        raise MoveError(
            f"move {move.sequence}: acceleration time {move.acceleration_ticks * period_s:.6g} s "
            f"is too long to leave move {before.sequence}, whose segment of "
            f"{before.segment_ticks * period_s:.6g} s leaves {longest * period_s:.6g} s of it "
            f"(t_seg >= t_acc + t_acc(next) + 2 tau): accelerate within that, or wait until move "
            f"{before.sequence} is complete"
        )


def check_configuration(before: Move, move: Move) -> None:
    """A Cartesian segment keeps its configuration.

    Raises:
        MoveError: it has another than the segment before.
    """
    if move.mode is Mode.CARTESIAN and move.configuration != before.configuration:
        raise MoveError(
            f"move {move.sequence}: a Cartesian segment cannot change the configuration from "
            f"'{before.configuration}' to '{move.configuration}': move in joint mode first"
        )


def check_transition(before: Segment, move: Move) -> None:
    """A Cartesian transition from or into joint mode needs what was planned of the joints.

    Raises:
        MoveError: a joint-mode segment was not planned.
    """
    if move.transition is Transition.JOINT or before.rests:
        return
    for each, way in ((before.move, "leave"), (move, "lead into")):
        if each.mode is Mode.JOINT and each.joints is None:
            raise MoveError(
                f"move {move.sequence}: its Cartesian transition cannot {way} move "
                f"{each.sequence}, which is in joint mode and was not planned: plan both moves, or "
                f"use a joint transition"
            )


WEAVES: Final = 0.1
"""Rad a path may turn further where goals move by themselves: it is planned for the moment it is
fixed at, and D(r) is well defined up to a whole half turn."""


def from_goal_to_goal(
    before: Move, move: Move, tick: int, period_s: float, settled: float | None = None
) -> DriveTransform:
    """D(1) of ``move``, also in joint mode: how far its tool is to travel and turn.

    Goals that are observed are taken as they are at ``tick``; what time moves as it is at the
    hand-over: the new one where its transition begins, the one before at its local time ``settled``
    (periods; its end, if that is not given), from which on D(1) is fixed.
    """
    goal = move.target
    start = Moment(tick, 0.0, -move.acceleration_ticks * period_s)
    clock = before.segment_ticks if settled is None else settled
    origin = before.target.pose(Moment(tick, 1.0, clock * period_s))
    return DriveTransform.between(goal.left(start), origin, goal.right(start))


def check_path(before: Move, move: Move, tick: int, period_s: float) -> None:
    """A Cartesian segment keeps its configuration and turns by 0.8 pi at most.

    Raises:
        MoveError: another configuration, or too large a rotation.
    """
    if move.mode is Mode.JOINT:
        return
    check_configuration(before, move)
    drive = from_goal_to_goal(before, move, tick, period_s)
    still = before.target.constant and move.target.constant
    if not drive.psi <= MAX_ROTATION + (0.0 if still else WEAVES):
        raise MoveError(
            f"move {move.sequence}: a Cartesian rotation of {drive.psi:.4g} rad exceeds 0.8 pi = "
            f"{MAX_ROTATION:.4g} rad: split it in two with a position between, "
            f"or move in joint mode"
        )


def check_feed(move: Move, feed_rate: float, period_s: float) -> None:
    """A transition at ``feed_rate`` must not take longer than can be told to the joints.

    Raises:
        MoveError: t_acc / feed_rate over 100 s.
    """
    time = move.longest_entry * period_s
    if time > LONGEST_ACCELERATION_S * feed_rate:
        raise MoveError(
            f"move {move.sequence}: acceleration time {time:g} s at a feed rate of {feed_rate:g} "
            f"would take {time / feed_rate:g} s, over {LONGEST_ACCELERATION_S:g} s: "
            f"feed at {time / LONGEST_ACCELERATION_S:g} or more, or accelerate in less time"
        )
