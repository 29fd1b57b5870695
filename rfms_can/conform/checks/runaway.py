"""Checks 40e and 40f: a joint that moves away from its set-point loses its torque, no other."""

from collections.abc import Mapping, Sequence
from typing import Final

from rfms_can.conform.checks.emergencies import count, emergency, no_more_than, noted, off, silent
from rfms_can.conform.checks.ladder import bare
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.records import Measure
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

S, F, P = NodeState, FaultCode, Parameter

# On the bench: counts from 161 counts of error on; 3.2 counts a cycle are motion, 32 are fast.
UNTIL: Final = (25, 50, 75, 100, 125, 150)
"""Where the encoder goes first, counts away from the set-point: within the bound."""
RUNAWAYS: Final[tuple[tuple[int, ...], ...]] = (
    (170, 190, 210, 230, 250),
    (158, 162, 166, 170, 174, 178),  # the first is within the bound, 4 counts are motion
    (180, 208, 236, 264, 292),  # braked to 0.93
    (170, 201, 232, 263, 294),  # nearly fast
    (170, 203),  # fast: the second cycle is enough
    (170, 190, 190, 210, 230, 250, 270, 290),  # it stood once: counted from there
    (180, 200, 220, 240, 260, 280),  # braked to 0.67 at once: counted from there
)
"""Encoder positions; at the last the torque goes off, and not before."""
NONE: Final[tuple[tuple[int, ...], ...]] = (
    (152, 154, 156, 158, 159, 159),  # within the bound
    (162, 165, 168, 171, 174, 177, 180, 183),  # 3 counts are no motion
    (170, 190, 210, 230, 230, 250, 270, 290, 310, 310),  # four cycles, twice
    (180, 206, 229, 249, 266, 280, 292),  # its servo brakes it
    (190, 191, 192),  # one fast cycle
    (190, 170, 190, 170, 190),  # it comes back
)
BOUNDS: Final[tuple[tuple[Mapping[Parameter, float], float], ...]] = (
    ({P.FOLLOWING_ERROR_LIMIT: 0.016}, 0.008),
    ({P.KP: 2000.0}, 0.0025),
    ({P.KP: 0.0, P.FOLLOWING_ERROR_LIMIT: 0.02}, 0.01),
    ({P.SPEED_LIMIT: 1.0}, 0.01),
    ({P.KP: 500.0, P.TORQUE_LIMIT: 6.0}, 0.006),
)
"""Other parameters, and the error from which it counts then, rad."""
BOUND: Final = 0.02
NEAR: Final = 24
"""Counts: how far from a joint its stop may begin, a quarter of a step."""
WHOLE: Final = 11
"""Cycles of a stop, 20 counts each, until RUNAWAY: 160 counts are the bound, then five cycles."""
WATCHED: Final = 3
"""Cycles at rest before."""


def runaway(t: Tester) -> None:
    """In OPERATIONAL, by the numbers; with other parameters; where the arm complies, not at all."""
    for sign in (1, -1):
        for way in RUNAWAYS:
            _operational(t, {}, (*UNTIL, *way), sign, BOUND)
        for way in NONE:
            _operational(t, {}, (*UNTIL, *way), sign, None)
    for changes, bound in BOUNDS:
        t.configure(changes)
        least = int(bound / count(t))
        way = (*range(12, least - 17, 12), least, *(least + 15 * n for n in range(1, 6)))
        _operational(t, changes, way, 1, bound)
    _operational(t, {}, (*UNTIL, *RUNAWAYS[0], 270), 1, None, complies=True)
    _error_shrinks(t)


def _operational(
    t: Tester,
    changes: Mapping[Parameter, float],
    way: Sequence[int],
    sign: int,
    bound: float | None,
    *,
    complies: bool = False,
) -> None:
    """The encoder goes ``way``, the set-point stays; torque goes off at its end, or nothing."""
    t.operational(changes)
    if complies:
        told = (*t.own_first([1.0, *[0.0] * 5]), *[0.0] * 6, 0.0, 1, 0, 0.0, 1, 1)
        t.rows(1, told)
    t.run(WATCHED)
    goal = t.measured
    for number, counts in enumerate(way):
        _away(t, goal + sign * counts * count(t))
        t.sync()
        t.measure()
        answers = t.setpoint(goal)
        if bound is not None and number == len(way) - 1:
            _lost(t, answers, goal - t.measured, bound)
            return
        t.only(answers, ("ERROR",), f"{counts} counts away, of {way}")
        t.only(t.errors(), ("DAC",))
    noted(t, S.OPERATIONAL)


def _away(t: Tester, theta: float) -> None:
    """Go there; the tachometer tells no more than an error of a rate may be."""
    t.move_to(theta, no_more_than(t))


def _lost(t: Tester, answers: Answers, error: float, bound: float, *others: FaultCode) -> None:
    off(t, answers)
    emergency(
        *(t, answers, F.RUNAWAY),
        culprit=t.joint,
        frame=t.codec(Measure, t.joint).id,
        value=error,
        bound=bound,
        others=others,
        tolerance=1e-6,
    )
    noted(t, S.FAULT, F.RUNAWAY, *others)
    silent(t)


def _error_shrinks(t: Tester) -> None:
    """A set-point that comes after the joint faster than the joint goes begins the count again."""
    t.operational()
    t.run(WATCHED)
    goal = t.measured
    way = [(0, n) for n in (*UNTIL, 170, 190, 210, 230)]
    way += [(4, 234), (7, 254), (9, 274), (10, 294), (10, 314), (10, 334)]
    for number, (ahead, counts) in enumerate(way, 1):
        _away(t, goal + counts * count(t))
        t.sync()
        t.measure()
        answers = t.setpoint(goal + ahead * count(t))
        if number == len(way):
            error = goal + ahead * count(t) - t.measured
            _lost(t, answers, error, BOUND)
            return
        t.only(answers, ("ERROR",), f"{counts} counts away, the set-point {ahead}")
        t.only(t.errors(), ("DAC",))


def runaway_of_a_stop(t: Tester) -> None:
    """A controlled stop, and homing, are watched too."""
    for way in (RUNAWAYS[0], RUNAWAYS[4]):
        t.operational()
        t.run(WATCHED)
        goal = t.measured
        t.command(Command.QUICKSTOP)
        for number, counts in enumerate((*UNTIL, *way), 1 - len(UNTIL)):
            _away(t, goal + counts * count(t))
            t.sync(S.QUICKSTOP)
            answers = t.measure()
            if number == len(way):
                _lost(t, bare(answers), goal - t.measured, BOUND)
                break
            t.only(answers, ("DAC",), f"{counts} counts away")
    t.configure()
    begin = t.theta = -0.9
    t.command(Command.HOME)
    step = t.parameters[P.HOMING_SPEED] * t.parameters[P.PERIOD]
    for number in range(10):  # the goal goes on by 12.8 counts, the joint back by 20
        _away(t, begin - 20 * number * count(t))
        t.sync(S.HOMING)
        t.measure()
        answers = t.reference(valid=0)
        if number == 9:
            error = 10 * step + 9 * 20 * count(t)
            _lost(t, answers, error, BOUND)
            return
        t.only(answers, ("DAC",), f"cycle {number} of homing backwards")


def begins_again(t: Tester) -> None:
    """A stop, and an index that is found, forget what went away before, and from where."""
    for stopped in (4, 3, 1):
        _stopped_while_away(t, stopped)
    _far_from_its_set_point(t)
    _homed_while_away(t)
    _driven_again(t)


def _stopped_while_away(t: Tester, stopped: int) -> None:
    """Cycles away before QUICKSTOP count for nothing; the stop begins near the joint."""
    t.operational(theta=0.5)
    t.run(WATCHED)
    goal = t.measured
    way = [*UNTIL, *(170 + 20 * n for n in range(stopped + WHOLE))]
    for number, counts in enumerate(way, -len(UNTIL)):
        if number == stopped:
            t.command(Command.QUICKSTOP)
            begin = t.measured + NEAR * count(t)
        _away(t, goal - counts * count(t))
        t.sync(S.QUICKSTOP if number >= stopped else S.OPERATIONAL)
        answers = bare(t.measure())
        if number < stopped:
            t.only(t.setpoint(goal) + t.errors(), ("ERROR", "DAC"))
        elif number == stopped + WHOLE - 1:
            _lost(t, answers, begin - t.measured, BOUND)
        else:
            t.only(answers, ("DAC",), f"{counts} counts away, QUICKSTOP {stopped} cycles after")


def _far_from_its_set_point(t: Tester) -> None:
    """A stop that begins far from the set-point is no runaway, wherever the joint is."""
    for theta in (0.5, -0.5):
        for sign in (1, -1):
            t.operational(theta=theta)
            t.run(WATCHED)
            goal = t.measured
            for counts in (72, 144, 144, 216, 216, 288, 288):
                _away(t, goal + sign * counts * count(t))
                t.sync()
                t.only(t.measure() + t.setpoint(goal) + t.errors(), ("ERROR", "DAC"))
            t.command(Command.QUICKSTOP)
            for number in range(3):
                t.only(bare(t.sync(S.QUICKSTOP) + t.measure()), ("DAC",), f"cycle {number}")
            noted(t, S.QUICKSTOP)


def _homed_while_away(t: Tester) -> None:
    """Away before the index came, and after it: four cycles before, the fifth with it."""
    t.configure()
    t.zero = 0
    step = t.parameters[P.HOMING_SPEED] * t.parameters[P.PERIOD]
    begin = t.theta = 0.06
    t.command(Command.HOME)
    for number in range(14):
        _away(t, begin - 20 * number * count(t))
        t.sync(S.HOMING)
        t.measure()
        error = step * min(number + 1, 8) + 20 * number * count(t)
        answers = t.reference(valid=int(number == 8), index_counts=0)
        if number == 13:
            _lost(t, answers, error, BOUND)
            return
        t.only(answers, ("DAC",), f"cycle {number}, the index in the ninth")


def _driven_again(t: Tester) -> None:
    """After a pause of homing its first cycle away is the first."""
    t.configure({P.PERIOD: 0.05, P.HOMING_SPEED: 2.0})
    t.theta, t.zero = -0.5, 20000
    t.command(Command.HOME)
    for moved in (0.0, 0.1, 0.13):
        t.move_to(t.theta + moved)
        t.only(bare(t.sync(S.HOMING) + t.measure() + t.reference(valid=0)), ("DAC",))
    t.only(bare(t.sync(S.READY) + t.measure()), (), "a pause")
    for moved in (-0.12, -0.112):
        t.move_to(t.theta + moved)
        answers = bare(t.sync(S.HOMING) + t.measure() + t.reference(valid=0))
        t.only(answers, ("DAC",), f"moved by {moved} rad")
