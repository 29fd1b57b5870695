"""Checks 35 to 38: what lacks, for how many cycles, and what happens then."""

from collections.abc import Callable, Mapping
from typing import Final

from rfms_can.conform.checks.emergencies import (
    emergency,
    noted,
    off,
    silent,
)
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.contract import JOINT_SETPOINT_BELONGS
from rfms_can.wire.nodes import JOINTS, MASTER, PLANT
from rfms_can.wire.records import Dac, JointError, Measure, Rows, Setpoint
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


def damping_leaves_the_range(t: Tester) -> None:
    """A joint that is damped loses its torque where it leaves its range, and may jump there."""
    for sign in (1, -1):
        _damped(t)
        end = t.parameters[Parameter.POSITION_MAX if sign > 0 else Parameter.POSITION_MIN]
        t.theta, t.speed = end + sign * 0.049, sign * 2.0
        t.only(t.measure(), ("DAC",), "a jump to the end of the range, and on")
        noted(t, S.FAULT, F.SETPOINT_MISSING, F.SOFT_LIMIT)
        t.theta = end + sign * 0.051
        answers = t.measure()
        _leaves(t, answers, t.measured, end + sign * 0.05, F.SETPOINT_MISSING, F.SOFT_LIMIT)
    exact = {Parameter.COUNTS_PER_UNIT: 80.0, Parameter.RATE_PER_CODE: 2.0**-9}
    for end, sign in ((224, 1), (-204, -1)):  # 2.8 and -2.55 rad, to the bit
        _damped(t, exact)
        for code, faults in ((369, ()), (370, (F.SOFT_LIMIT,))):  # 0.0325 rad to stop, almost
            t.speed = sign * code * 2.0**-9
            t.only(t.measure(counts=t.zero + end - sign * 5), ("DAC",))
            noted(t, S.FAULT, F.SETPOINT_MISSING, *faults)
        t.speed = 0.0
        t.only(t.measure(counts=t.zero + end), ("DAC",), "the end of the range and 0.05 rad")
        off(t, t.measure(counts=t.zero + end + sign))
    for counts, value in ((2**31 - 1, 1e9), (-(2**31), -1e9)):  # farther than EMCY can say
        _damped(t, {Parameter.COUNTS_PER_UNIT: 1.0})
        p = t.parameters
        bound = p[Parameter.POSITION_MAX] + 0.05 if value > 0 else p[Parameter.POSITION_MIN] - 0.05
        _leaves(t, t.measure(counts=counts), value, bound, F.SETPOINT_MISSING)


def _damped(t: Tester, changes: Mapping[Parameter, float] | None = None) -> None:
    """In FAULT after five cycles without SETPOINT."""
    t.operational(changes)
    t.run(1)
    for _ in range(6):
        t.sync()
        t.measure()
    noted(t, S.FAULT, F.SETPOINT_MISSING)


def _leaves(t: Tester, answers: Answers, value: float, bound: float, *others: FaultCode) -> None:
    off(t, answers)
    told = dict(culprit=t.joint, frame=0, value=value, bound=bound)
    emergency(t, answers, F.HARD_LIMIT, **told, others=others)  # type: ignore[arg-type]
    noted(t, S.FAULT, F.HARD_LIMIT, *others)
    silent(t)
