"""Checks 35 to 42: what lacks, what is wrong, for how many cycles, and what happens then."""

from collections.abc import Callable
from typing import Final

from rfms_can.conform.checks.cycles import BARE
from rfms_can.conform.checks.emergencies import (
    count,
    emergency,
    noted,
    off,
    silent,
    step_limit,
)
from rfms_can.conform.outcome import CheckSkipped
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.contract import JOINT_SETPOINT_BELONGS
from rfms_can.wire.nodes import JOINTS, MASTER, PLANT
from rfms_can.wire.records import Dac, JointError, Measure, Rows, Setpoint, Sync
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState, Parameter

S, F = NodeState, FaultCode
HOMED: Final = 0.1


def bare(answers: Answers) -> Answers:
    """Without the HEARTBEAT of each twelfth cycle."""
    return Answers(h for h in answers if h.name != "HEARTBEAT")


def operational(t: Tester) -> None:
    """Three good cycles at rest."""
    t.operational(theta=HOMED)
    t.run(3)


# --- set-points -----------------------------------------------------------------------------------


def no_setpoint(t: Tester, cycle: Callable[[Tester], Answers]) -> None:
    """Two bad cycles are held; three stop; five damp; twenty-five switch off."""
    operational(t)
    for _ in range(2):
        t.only(bare(t.sync()), ())
        t.only(cycle(t), (), "no set-point")
    t.only(bare(t.run()), ("ERROR", "DAC"), "a good cycle after two without")
    noted(t, S.OPERATIONAL, F.SETPOINT_MISSING)
    for number in range(1, 27):
        answers = bare(t.sync())
        missed = number - 1
        _rung(t, answers, missed)
        if missed == 25:
            break
        t.only(bare(cycle(t)), ("DAC",) if missed >= 3 else (), f"cycle after {missed} misses")
    noted(t, S.FAULT, F.SETPOINT_MISSING)
    silent(t)


_RUNGS: Final = {3: S.QUICKSTOP, 5: S.FAULT, 25: S.FAULT}


def _rung(t: Tester, answers: Answers, missed: int) -> None:
    """At SYNC, after so many cycles without a set-point."""
    if missed not in _RUNGS:
        t.only(answers, (), f"SYNC after {missed} cycles without a set-point")
        return
    if missed == 25:
        off(t, answers)
    else:
        t.only(answers, ("EMCY",), f"SYNC after {missed} cycles without a set-point")
    emergency(
        *(t, answers, F.SETPOINT_MISSING),
        culprit=MASTER,
        frame=t.codec(Setpoint, 1).id,
        value=missed,
        bound=missed,
    )
    noted(t, _RUNGS[missed], F.SETPOINT_MISSING)


def setpoint_lost(t: Tester) -> None:
    """No SETPOINT at all."""
    no_setpoint(t, lambda t: t.measure() + t.errors())


def held_rung(t: Tester) -> None:
    """A set-point that cannot be used is as good as none, for three cycles."""
    rest = t.vectors.rest_pose

    def old(t: Tester) -> Answers:
        return t.setpoint(cycle=t.cycle - 1)

    def ahead(t: Tester) -> Answers:
        return t.setpoint(cycle=t.cycle + 1)

    def no_rotation(t: Tester) -> Answers:
        return t.give(t.setpoint_frame(0, a_x=rest.a[0] + 1e-4))

    def unreachable(t: Tester) -> Answers:
        return t.give(t.setpoint_frame(0, p_x=3.0))

    def inside(t: Tester) -> Answers:
        return t.give(t.setpoint_frame(0, p_x=0.01, p_y=0.02))

    def unfinished(t: Tester) -> Answers:
        return t.give(t.setpoint_frame(JOINT_SETPOINT_BELONGS))

    def no_start(t: Tester) -> Answers:
        return t.give(t.setpoint_frame(state=4), t.angles_frame(t.measured))

    far = () if t.joint == 1 else (unreachable,)  # joint 1 turns towards any place
    for wrong in (old, ahead, unfinished, no_start, no_rotation, inside, *far):
        operational(t)
        for number in range(3):
            t.only(bare(t.sync()), (), f"{wrong.__name__}, {number} misses")
            t.measure()
            t.only(wrong(t) + t.errors(), (), wrong.__name__)
        answers = bare(t.sync())
        t.only(answers, ("EMCY",), wrong.__name__)
        emergency(
            *(t, answers, F.SETPOINT_MISSING),
            culprit=MASTER,
            frame=t.codec(Setpoint, 1).id,
            value=3,
            bound=3,
        )
        noted(t, S.QUICKSTOP, F.SETPOINT_MISSING)


def stop_is_not_disturbed(t: Tester) -> None:
    """After a stop SETPOINT_1 is still expected while SYNC says OPERATIONAL, and only then."""
    operational(t)
    t.command(Command.QUICKSTOP)
    for _ in range(4):
        t.sync()
        t.only(t.measure(), ("DAC",), "a stop")
    noted(t, S.QUICKSTOP, F.SETPOINT_MISSING)
    for _ in range(2):
        t.only(bare(t.sync()), ())
        t.only(t.setpoint(), (), "SETPOINT in a stop")
        t.only(t.measure(), ("DAC",))
    for _ in range(8):
        t.only(bare(t.sync(S.QUICKSTOP)), (), "SYNC QUICKSTOP asks for no SETPOINT")
        t.only(t.measure(), ("DAC",))
    noted(t, S.QUICKSTOP, F.SETPOINT_MISSING)
    for missed in range(6):
        answers = bare(t.sync())
        # the rung of three cycles has been passed before
        t.only(answers, ("EMCY",) if missed == 5 else (), f"OPERATIONAL, {missed} misses")
        t.only(t.measure(), ("DAC",))
    noted(t, S.FAULT, F.SETPOINT_MISSING)
    # damping goes on without SETPOINT where SYNC does not ask for it
    for _ in range(25):
        t.only(bare(t.sync(S.QUICKSTOP)), ())
        t.only(t.measure(cycle=t.cycle + 7), ("DAC",), "damping takes MEASURE of any cycle")
    noted(t, S.FAULT, F.SETPOINT_MISSING)


# --- MEASURE --------------------------------------------------------------------------------------


def measure_lost(t: Tester) -> None:
    """Two cycles without MEASURE are held, three switch off; an old one is none."""
    for old in (False, True):
        operational(t)
        for _ in range(2):
            for number in range(2):
                t.only(bare(t.sync()), (), f"{number} cycles without MEASURE")
                t.only(_blind(t, old), (), "without MEASURE")
            t.only(bare(t.run()), ("ERROR", "DAC"), "a good cycle")
        for number in range(3):
            t.only(bare(t.sync()), (), f"{number} cycles without MEASURE")
            t.only(_blind(t, old), (), "without MEASURE")
        answers = bare(t.sync())
        off(t, answers)
        emergency(
            *(t, answers, F.MEASURE_MISSING),
            culprit=PLANT,
            frame=t.codec(Measure, t.joint).id,
            value=3,
            bound=3,
        )
        noted(t, S.FAULT, F.MEASURE_MISSING)
        silent(t)


def _blind(t: Tester, old: bool) -> Answers:
    """A cycle without MEASURE, or with an old one."""
    answers = t.measure(cycle=t.cycle - 1) if old else Answers()
    return answers + t.setpoint() + t.errors()


def measure_lost_in_a_stop(t: Tester) -> None:
    """A stop needs MEASURE too, but takes one of any cycle."""
    operational(t)
    t.command(Command.QUICKSTOP)
    for number in range(3):
        t.sync(S.QUICKSTOP)
        dac: Dac = t.one(t.measure(cycle=t.cycle + 5 + number), "DAC", "MEASURE of another cycle")
        t.equal(dac.cycle, (t.cycle + 5 + number) & 0xFF, "cycle of DAC: that of MEASURE")
    for number in range(3):
        t.only(bare(t.sync(S.QUICKSTOP)), (), f"{number} cycles without MEASURE")
    answers = bare(t.sync(S.QUICKSTOP))
    off(t, answers)
    emergency(
        *(t, answers, F.MEASURE_MISSING),
        culprit=PLANT,
        frame=t.codec(Measure, t.joint).id,
        value=3,
        bound=3,
    )
    noted(t, S.FAULT, F.MEASURE_MISSING)


# --- errors and rows ------------------------------------------------------------------------------


def error_lost(t: Tester) -> None:
    """The ERROR of each other joint: two cycles are held, three stop; the first is named."""
    others = [j for j in JOINTS if j != t.joint]
    for lacking in (*((j,) for j in others), (others[1], others[3]), tuple(others)):
        operational(t)
        for number in range(5):
            if number == 2:
                t.only(bare(t.run()), ("ERROR", "DAC"), "a good cycle")
                continue
            t.only(bare(t.sync()), ())
            t.only(t.measure() + t.setpoint(), ("ERROR",))
            t.only(t.errors(without=lacking), (), f"no ERROR of {lacking}")
        t.only(bare(t.sync()), ())
        t.only(t.measure() + t.setpoint() + t.errors(without=lacking), ("ERROR",))
        answers = bare(t.sync())
        t.only(answers, ("EMCY",), f"no ERROR of {lacking}")
        emergency(
            *(t, answers, F.ERROR_MISSING),
            culprit=lacking[0],
            frame=t.codec(JointError, lacking[0]).id,
            value=3,
            bound=3,
        )
        noted(t, S.QUICKSTOP, F.ERROR_MISSING)


def rows_lost(t: Tester) -> None:
    """A set that did not come: the old one acts for two cycles, then the joint stops."""
    operational(t)
    t.row_set = 5
    for _ in range(2):
        t.only(bare(t.run()), ("ERROR", "DAC"), "the old rows act")
    noted(t, S.OPERATIONAL, F.ROWS_MISSING)
    t.row_set = 0
    t.run()
    t.row_set = 5
    t.run(2)
    answers = bare(t.sync())
    t.only(answers, ("EMCY",), "three cycles without rows")
    emergency(
        *(t, answers, F.ROWS_MISSING),
        culprit=MASTER,
        frame=t.codec(Rows, t.joint).id,
        value=3,
        bound=3,
    )
    noted(t, S.QUICKSTOP, F.ROWS_MISSING)


def while_homing(t: Tester) -> None:
    """A joint that homes while the bus runs is stopped too: PREOP, and no HOME before RESET."""
    t.configure()
    t.theta = -0.9
    t.command(Command.HOME)
    for number in range(3):
        t.only(bare(t.sync()), (), f"{number} cycles")
        t.only(t.measure() + t.reference(valid=0), (), "HOMING, SYNC OPERATIONAL")
    answers = bare(t.sync())
    t.only(answers, ("EMCY",))
    t.equal([e.fault for e in answers.of("EMCY")], [F.SETPOINT_MISSING], "faults")
    noted(t, S.PREOP, F.SETPOINT_MISSING)
    t.only(t.command(Command.HOME), (), "HOME before RESET")
    t.state_is(S.PREOP)
    t.only(t.command(Command.RESET), ())
    noted(t, S.PREOP)
    t.command(Command.HOME)
    t.state_is(S.HOMING)


# --- steps ----------------------------------------------------------------------------------------


def setpoint_step(t: Tester) -> None:
    """Nothing of a step beyond the bound acts; one just inside is taken. Holding widens it."""
    for sign in (1.0, -1.0):
        for held in range(3):
            for part, refused in ((0.995, False), (1.005, True), (25.0, True)):
                operational(t)
                before = t.measured
                for _ in range(held):
                    t.sync()
                    t.measure()
                    t.errors()
                bound = step_limit(t) * (1 + held)
                t.sync()
                t.measure()
                answers = t.setpoint(before + sign * part * bound)
                if not refused:
                    t.only(answers, ("ERROR",), f"a step of {part} of the bound")
                    continue
                t.only(answers, ("EMCY",), f"a step of {part} of the bound")
                emergency(
                    *(t, answers, F.SETPOINT_STEP),
                    culprit=MASTER,
                    frame=t.codec(Setpoint, 1).id,
                    value=sign * part * bound,
                    bound=bound,
                    others=(F.SETPOINT_MISSING,) if held else (),
                    tolerance=2e-5,
                )
                t.state_is(S.QUICKSTOP)
                t.only(t.errors(), (), "no DAC of the step")
                t.sync(S.QUICKSTOP)
                t.one(t.measure(), "DAC", "the stop")


def too_far(t: Tester) -> None:
    """An error that ERROR cannot say is a step, however small the step."""
    t.operational({Parameter.PERIOD: 1.0}, theta=-1.0)
    t.run(2)
    t.sync()
    t.theta = 1.01
    t.measure()
    answers = t.setpoint(-1.0)
    t.only(answers, ("EMCY",), "an error of 2.01 rad")
    t.equal([e.fault for e in answers.of("EMCY")], [F.SETPOINT_STEP], "faults")


def encoder_jump(t: Tester) -> None:
    """A step that no joint can make is predicted over, twice; then the joint stops."""
    for sign in (1.0, -1.0):
        operational(t)
        bound = step_limit(t)
        inside = int(bound / count(t)) - 1
        for counts in (inside, -inside):
            t.sync()
            t.measure(counts=t.counts() + counts)
            error: JointError = t.one(t.setpoint(), "ERROR")
            t.near(error.error, -counts * count(t), 1e-6, "error of a step that a joint can make")
            t.errors()
            t.run(1)
            t.run(1)
        noted(t, S.OPERATIONAL)
        jump = round(sign * (bound / count(t) + 2))
        t.speed = 0.2 * sign
        for number in (1, 2):
            t.sync()
            t.measure(counts=t.counts() + number * jump)
            told: JointError = t.one(t.setpoint(), "ERROR")
            way = (number - 1) * t.measured_speed * t.parameters[Parameter.PERIOD]
            t.near(told.error, -way, 1e-6, f"error of prediction {number}")
            t.only(t.errors(), ("DAC",))
        noted(t, S.OPERATIONAL, F.ENCODER_GLITCH)
        t.sync()
        answers = t.measure(counts=t.counts() + 3 * jump)
        t.only(answers, ("EMCY", "DAC"), "a third jump")
        emergency(
            *(t, answers, F.ENCODER_GLITCH),
            culprit=PLANT,
            frame=t.codec(Measure, t.joint).id,
            value=3 * jump * count(t) - t.measured_speed * t.parameters[Parameter.PERIOD],
            bound=bound,
            tolerance=1e-5,
        )
        noted(t, S.QUICKSTOP, F.ENCODER_GLITCH)


def encoder_unseen(t: Tester) -> None:
    """After a cycle without MEASURE an encoder may have gone twice as far."""
    for sign in (1, -1):
        operational(t)
        inside = int(1.95 * step_limit(t) / count(t))
        t.sync()
        t.setpoint()
        t.errors()
        t.sync()
        t.measure(counts=t.counts() + sign * inside)
        error: JointError = t.one(t.setpoint(), "ERROR")
        t.near(error.error, -sign * inside * count(t), 1e-6, "error after a cycle without MEASURE")
        noted(t, S.OPERATIONAL, F.MEASURE_MISSING)
        operational(t)
        t.speed = 0.1
        t.run(1)
        for number in (1, 2):
            t.sync()
            t.measure(counts=t.counts() + sign * 400 * number)
            t.setpoint()
            t.errors()
        t.sync()
        t.setpoint()
        t.errors()
        t.sync()
        answers = t.measure(counts=t.counts() + sign * 1600)
        moved = 2.0 * t.measured_speed * t.parameters[Parameter.PERIOD]
        emergency(
            *(t, answers, F.ENCODER_GLITCH),
            culprit=PLANT,
            frame=t.codec(Measure, t.joint).id,
            value=sign * 1600 * count(t) - moved,
            bound=2.0 * step_limit(t),
            others=(F.MEASURE_MISSING,),
            tolerance=1e-5,
        )


def encoder_returns(t: Tester) -> None:
    """Two jumps, one good sample, two jumps: never three in a row."""
    operational(t)
    for _ in range(3):
        for number in (1, 2):
            t.sync()
            t.measure(counts=t.counts() + 500 * number)
            t.only(t.setpoint() + t.errors(), ("ERROR", "DAC"))
        t.only(bare(t.run()), ("ERROR", "DAC"))
    noted(t, S.OPERATIONAL, F.ENCODER_GLITCH)


# --- range ----------------------------------------------------------------------------------------


def end_of_range(t: Tester) -> None:
    """0.05 rad beyond the range torque goes off; where only a stop can keep it, it stops."""
    p = t.bench()
    ends = (p[Parameter.POSITION_MAX], 1.0), (p[Parameter.POSITION_MIN], -1.0)
    for end, sign in ends:
        edge = end + sign * 0.05
        for beyond, fault in ((-2, None), (2, F.HARD_LIMIT)):
            t.operational(theta=end)
            t.run(2)
            # towards the edge in steps that a joint can make
            for part in (0.2, 0.4, 0.6, 0.8):
                t.theta = end + sign * 0.05 * part
                t.sync()
                t.measure()
                t.setpoint(end)
                t.errors()
            t.theta = edge + sign * beyond * count(t)
            t.sync()
            answers = t.measure()
            if fault is None:
                t.only(answers, (), "short of the edge")
                noted(t, S.OPERATIONAL)
                continue
            off(t, answers)
            told = dict(culprit=t.joint, frame=0, value=t.measured, bound=edge, tolerance=1e-5)
            emergency(t, answers, fault, **told)  # type: ignore[arg-type]
            noted(t, S.FAULT, fault)
        way = 0.5 * 1.5**2 / p[Parameter.ACCELERATION_LIMIT]
        for short, stops in ((0.003, False), (-0.003, True)):
            t.operational(theta=edge - sign * (way + short))
            t.run(1)
            t.speed = sign * 1.5
            t.sync()
            answers = t.measure()
            if not stops:
                t.only(answers, (), "fast, but far enough from the edge")
                continue
            t.only(answers, ("EMCY", "DAC"), "too fast for the way that is left")
            rest = t.measured + sign * 0.5 * t.measured_speed**2 / p[Parameter.ACCELERATION_LIMIT]
            told = dict(culprit=t.joint, frame=0, value=rest, bound=edge, tolerance=1e-4)
            emergency(t, answers, F.SOFT_LIMIT, **told)  # type: ignore[arg-type]
            noted(t, S.QUICKSTOP, F.SOFT_LIMIT)


# --- SYNC -----------------------------------------------------------------------------------------


def no_sync(t: Tester) -> None:
    """By the node's own clock: overdue after 1.5 of what CONFIG says, then once each."""
    clocks = (2.0, Parameter.PERIOD), (1.0, Parameter.BARRIER), (0.0, Parameter.PERIOD)
    for clock, period in clocks:
        if not t.line.virtual and clock == 0.0:
            continue
        _no_sync(t, {Parameter.CLOCK: clock, period: 0.1})


def _no_sync(t: Tester, changes: dict[Parameter, float]) -> None:
    t.ready({**BARE, Parameter.PERIOD: 0.004, Parameter.BARRIER: 0.004, **changes})
    t.start()
    t.run(2)
    begin = t.sync_ns
    # each moment: units since SYNC, what has come since the one before, the state
    moments: tuple[tuple[float, tuple[str, ...], NodeState, int], ...] = (
        (1.3, (), S.OPERATIONAL, 0),
        (1.7, (), S.OPERATIONAL, 1),
        (3.3, (), S.OPERATIONAL, 1),
        (3.7, ("EMCY",), S.QUICKSTOP, 3),
        (5.3, (), S.QUICKSTOP, 0),
        (5.7, ("EMCY",), S.FAULT, 5),
        (25.3, (), S.FAULT, 0),
        (25.7, ("EMCY", "DAC"), S.FAULT, 25),
    )
    for units, names, state, missed in moments:
        t.line.pass_until(begin + round(units * 0.1e9))
        answers = t.settle()
        t.only(answers, names, f"{units} periods after the last SYNC")
        if names:
            emergency(
                *(t, answers, F.SYNC_MISSING),
                culprit=MASTER,
                frame=t.codec(Sync).id,
                value=missed,
                bound=missed,
            )
        noted(t, state, *((F.SYNC_MISSING,) if units > 1.5 else ()))
        if state is S.QUICKSTOP:
            t.one(t.measure(cycle=t.cycle + 3), "DAC", "MEASURE goes on without SYNC")
    silent(t)


def sync_returns(t: Tester) -> None:
    """Two SYNCs lost, one that comes, two lost: it goes on; READY and PREOP do not mind at all."""
    if not t.line.virtual:
        raise CheckSkipped("needs a line whose time the tester holds")
    operational(t)
    for _ in range(3):
        t.only(bare(t.sync(skip=2)), (), "SYNC after two that were lost")
        t.only(t.measure() + t.setpoint() + t.errors(), ("ERROR", "DAC"))
    noted(t, S.OPERATIONAL, F.SYNC_MISSING)
    t.ready()
    t.only(t.elapse(1.0), (), "READY without SYNC")
    noted(t, S.READY)
    t.configure()
    t.sync(S.PREOP)
    t.only(bare(t.elapse(1.0)), (), "PREOP without SYNC")
    noted(t, S.PREOP)
    t.command(Command.HOME)
    t.sync(S.HOMING)
    answers = t.elapse(0.0035 * 4 + 0.001)
    t.only(answers, ("EMCY",), "HOMING without SYNC")
    noted(t, S.PREOP, F.SYNC_MISSING)


def numbers_skipped(t: Tester) -> None:
    """SYNC leaves out three numbers, and the steps that are allowed grow with them."""
    for gap, allowed in ((1, 1), (2, 2), (4, 4), (9, 4)):
        for sign in (1.0, -1.0):
            for part, refused in ((0.995, False), (1.02, True)):
                t.operational({Parameter.CLOCK: 1.0, Parameter.BARRIER: 20.0}, theta=HOMED)
                t.run(3)
                at = t.measured
                bound = step_limit(t)
                t.cycle += gap - 1
                t.sync()
                t.measure()
                answers = t.setpoint(at + sign * part * allowed * bound)
                names = ("EMCY",) if refused else ("ERROR",)
                t.only(answers, names, f"{gap} cycles on, a step of {part} of {allowed} bounds")
                if refused:
                    emergency(
                        *(t, answers, F.SETPOINT_STEP),
                        culprit=MASTER,
                        frame=t.codec(Setpoint, 1).id,
                        value=sign * part * allowed * bound,
                        bound=allowed * bound,
                        tolerance=2e-5,
                    )
                    continue
                t.only(t.errors(), ("DAC",))
                noted(t, S.OPERATIONAL)
