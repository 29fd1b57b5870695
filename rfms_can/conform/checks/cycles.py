"""Checks 26 to 34: from START on, what belongs to a cycle, and in which order."""

from collections.abc import Callable
from itertools import permutations
from typing import Final

from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.conform.vectors import set_hash
from rfms_can.wire.contract import BIAS_BELONGS, COMPLY_BELONGS, JOINT_SETPOINT_BELONGS
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Bias, Comply, Dac, JointError, Nmt, Setpoint
from rfms_can.wire.vocabulary import Command, NodeState, Parameter

S = NodeState
BARE: Final = {
    **dict.fromkeys((Parameter.COULOMB_POSITIVE, Parameter.COULOMB_NEGATIVE), 0.0),
    **dict.fromkeys((Parameter.VISCOUS, Parameter.KI, Parameter.KD), 0.0),
}
"""A servo that is its proportional term."""


def start(t: Tester) -> None:
    """START with the hash that the node holds, or with none; counters begin at 0."""
    t.ready()
    digest = set_hash(t.parameters)
    t.only(t.command(Command.START, t.joint, digest ^ 1), (), "START for another configuration")
    t.state_is(S.READY)
    t.skip_counter(Nmt, None, 15)
    for node, argument in ((0, digest), (t.joint, 0)):
        t.send(t.frame(Nmt, None, Command.START, node, argument))
        t.restart_counters()
        t.cycle, t.row_set = -1, 0
        t.settle()
        t.state_is(S.OPERATIONAL)
        answers = t.run(3)
        t.only(answers, ("ERROR", "DAC"))
        t.equal([h.counter for h in answers], [2, 2], "counters of ERROR and DAC after START")
        for other in (Command.START, Command.HOME, Command.RESET):
            t.only(t.command(other), (), f"{other.name} in OPERATIONAL")
            t.state_is(S.OPERATIONAL)
        answers = t.run()
        t.equal([h.counter for h in answers], [3, 3], "counters, which go on")
        t.only(t.command(Command.STOP), (), "STOP")
        t.state_is(S.READY)
        t.only(t.sync() + t.measure() + t.setpoint() + t.errors(), (), "in READY")


def start_within_a_cycle(t: Tester) -> None:
    """What the others told before START counts for nothing."""
    t.ready(BARE)
    row = [0.0, *[0.3] * 5]
    t.rows(1, (*t.own_first([1.0, *[0.0] * 5]), *t.own_first(row), 0.0, 1, 0, 0.0, 0, 0))
    t.sync()
    t.only(t.errors([[0.0, 0.0, 5.0]] * 5), (), "errors in READY")
    cycle = t.cycle
    t.start()
    t.cycle, t.row_set = cycle, 1
    t.only(t.setpoint() + t.measure(), ("ERROR",), "errors of before START count for nothing")
    t.cycle = -1
    t.only(Answers(h for h in t.run() if h.name != "HEARTBEAT"), ("ERROR", "DAC"), "cycle 0")
    t.state_is(S.OPERATIONAL)
    # enabled once more in a cycle that has had its DAC: no second one
    t.run()
    cycle = t.cycle
    t.only(t.command(Command.STOP), ())
    t.start()
    t.cycle = cycle
    t.only(t.measure(), (), "MEASURE after START, all six errors told before it")
    t.cycle = -1
    t.only(Answers(h for h in t.run() if h.name != "HEARTBEAT"), ("ERROR", "DAC"), "cycle 0")


def first_cycle(t: Tester) -> None:
    """Where it stands: no error, the rate of the encoder alone, no acceleration."""
    for speed in (0.0, 0.35, -0.5):
        t.operational(theta=0.7)
        t.speed = speed
        t.only(t.sync(), ("HEARTBEAT",), "SYNC 0")
        t.only(t.measure(), ())
        error: JointError = t.one(t.setpoint(), "ERROR")
        t.near(error.error, 0.0, 1e-6, "error")
        t.near(error.error_rate, -t.measured_speed, 1e-6, "error rate")
        t.equal((error.acceleration, error.cycle), (0.0, 0), "acceleration and cycle")
        dac: Dac = t.one(t.errors(), "DAC")
        t.equal(dac.cycle, 0, "cycle of DAC")


def order(t: Tester) -> None:
    """ERROR with the later of MEASURE and SETPOINT; DAC with the sixth error, whichever it is."""
    t.operational()
    others = [j for j in JOINTS if j != t.joint]

    def error_of(joint: int) -> Answers:
        return t.say(JointError, joint, 0.0, 0.0, 0.0, t.cycle & 0xFF)

    t.sync()
    t.only(t.setpoint(), (), "SETPOINT before MEASURE")
    t.only(t.measure(), ("ERROR",), "MEASURE after SETPOINT")
    t.only(t.setpoint() + t.measure(), (), "both again")
    for joint in others[:-1]:
        t.only(error_of(joint), (), f"ERROR_{joint}")
    t.only(error_of(others[0]), (), "an ERROR again")
    t.only(error_of(others[-1]), ("DAC",), "the sixth")
    t.only(error_of(others[-1]) + t.setpoint() + t.measure(), (), "more of them")
    # the five others first
    t.sync()
    t.only(t.measure(), (), "MEASURE before SETPOINT")
    for joint in reversed(others):
        t.only(error_of(joint), (), "the others' errors first")
    t.only(t.setpoint(), ("ERROR", "DAC"), "SETPOINT last")
    t.sync()
    for joint in others:
        t.only(error_of(joint), (), "the others' errors first")
    t.only(t.setpoint(), (), "SETPOINT before MEASURE")
    t.only(t.measure(), ("ERROR", "DAC"), "MEASURE last")
    # errors of another cycle do not count
    t.sync()
    t.only(t.setpoint() + t.measure(), ("ERROR",))
    t.only(t.errors(cycle=t.cycle - 1), (), "errors of the cycle before")
    t.only(t.errors(cycle=t.cycle + 1), (), "errors of the cycle after")
    t.only(t.errors(), ("DAC",))
    # nothing of the cycle before is left
    t.sync()
    t.only(t.setpoint(), ())
    t.sync()
    t.only(t.measure() + t.errors(), (), "without SETPOINT of this cycle")
    t.run(2)


def _parts(t: Tester) -> dict[str, Callable[[], Frame]]:
    """Frames of a whole set-point."""
    rest, extras = t.vectors.rest_pose, JOINT_SETPOINT_BELONGS | COMPLY_BELONGS | BIAS_BELONGS
    values = (*rest.o, *rest.a, *rest.p, 0.0, 0.0, 0.2, 0, 0, rest.configuration, 1)
    told = [0.0] * 6

    def setpoint(number: int) -> Frame:
        return t.frame(Setpoint, number, *values, t.cycle, 1, 2, extras)

    return {
        "SETPOINT_1": lambda: setpoint(1),
        "SETPOINT_2": lambda: setpoint(2),
        "JOINT_SETPOINT_1": lambda: t.angles_frame(t.measured),
        "JOINT_SETPOINT_2": lambda: t.angles_frame(t.measured, 2),
        "COMPLY": lambda: t.frame(Comply, None, *told, t.cycle & 0xFF),
        "BIAS": lambda: t.frame(Bias, None, *told, t.cycle & 0xFF),
    }


def whole_setpoint(t: Tester) -> None:
    """A joint waits for all that belongs to a set-point, whatever comes last."""
    t.operational()
    parts = _parts(t)
    orders = [list(order) for order in permutations(parts)][:: 37 if t.line.virtual else 120]
    for names in orders:
        t.sync()
        t.measure()
        for name in names[:-1]:
            t.only(t.give(parts[name]()), (), f"{name}, {names[-1]} yet to come")
        t.only(t.give(parts[names[-1]]()), ("ERROR",), f"{names[-1]} last")
        t.only(t.errors(), ("DAC",))
    for lost in parts:
        t.sync()
        t.measure()
        for name in parts:
            if name != lost:
                t.only(t.give(parts[name]()), (), f"{lost} lost")
        t.only(t.errors(), (), f"{lost} lost")
        t.run(2)
    # frames of another cycle do not complete it
    for late in parts:
        t.sync()
        t.measure()
        t.cycle -= 1
        stale = parts[late]()
        t.cycle += 1
        for name in parts:
            t.only(t.give(stale if name == late else parts[name]()), (), f"{late} is old")
        t.run(2)
    t.sync()
    t.measure()
    t.only(t.setpoint(), ("ERROR",))


def surplus(t: Tester) -> None:
    """A second pose that SETPOINT_1 does not announce; a bit of extras without a name."""
    t.operational()
    parts = _parts(t)
    t.sync()
    t.measure()
    t.only(t.give(parts["SETPOINT_2"]()), ())
    t.only(t.setpoint(), (), "one pose announced, two there")
    t.run(1)
    for bit in range(3, 8):
        t.sync()
        t.measure()
        first = t.setpoint_frame(JOINT_SETPOINT_BELONGS | 1 << bit)
        t.only(t.give(first, t.angles_frame(0.0)), (), f"bit {bit} of extras")
        t.run(1)
    # frames that do not belong to the set-point do no harm
    t.sync()
    t.measure()
    told = (0.002, 0.002, 0.002, 0.002, 0.002, 0.002, t.cycle & 0xFF)
    t.only(t.give(t.frame(Bias, None, *told), t.frame(Comply, None, *told)), ())
    t.near(t.one(t.setpoint(), "ERROR").error, 0.0, 1e-6, "error, COMPLY without its bit")
    dac: Dac = t.one(t.errors(), "DAC")
    t.equal(dac.force_dac, 0, "force DAC, BIAS without its bit")
    angle = t.vectors.rest_angles[t.index]
    t.operational(theta=angle)
    t.sync()
    t.measure()
    t.only(t.give(t.angles_frame(t.measured + 0.005)), ())
    error: JointError = t.one(t.give(t.setpoint_frame(0)), "ERROR")
    want = "error by the pose, JOINT_SETPOINT without its bit"
    t.near(error.error, angle - t.measured, 2e-6, want)


def compliant(t: Tester) -> None:
    """COMPLY moves the set-point; its rate counts while the rows are rigid."""
    for selection in (0, 1):
        t.operational()
        row = [1.0, *[0.0] * 5]
        values = (*t.own_first(row), *[0.0] * 6, 0.0, 1, 0, 0.0, selection, 0)
        t.rows(1, values)
        t.run(2)
        for displacement, change in ((1e-4, 1e-4), (1e-4, 0.0), (-3e-4, -4e-4), (0.0, 3e-4)):
            t.sync()
            t.measure()
            own = [0.5] * 6
            own[t.index] = displacement
            frames = (
                t.setpoint_frame(JOINT_SETPOINT_BELONGS | COMPLY_BELONGS),
                t.angles_frame(t.measured),
                t.frame(Comply, None, *own, t.cycle & 0xFF),
            )
            error: JointError = t.one(t.give(*frames), "ERROR")
            t.near(error.error, displacement, 1e-7, "error")
            rate = 0.0 if selection else change / t.parameters[Parameter.PERIOD]
            t.near(error.error_rate, rate, 1e-4, f"error rate, selection {selection}")
            t.equal(error.acceleration, 0.0, "acceleration")
            t.errors()


def biased(t: Tester) -> None:
    """BIAS goes out on the force DAC of its cycle, as far as that reaches."""
    t.operational(BARE)
    scale = t.parameters[Parameter.TORQUE_PER_FORCE_CODE]
    for bias in (1.0, -1.0, None, 0.004, 50.0, -50.0, None):
        t.sync()
        t.measure()
        frames = [t.setpoint_frame(JOINT_SETPOINT_BELONGS | (BIAS_BELONGS if bias else 0))]
        frames.append(t.angles_frame(t.measured))
        if bias is not None:
            own = [0.1] * 6
            own[t.index] = bias
            frames.append(t.frame(Bias, None, *own, t.cycle & 0xFF))
        t.one(t.give(*frames), "ERROR")
        dac: Dac = t.one(t.errors(), "DAC")
        code = max(-2047, min(2047, round((bias or 0.0) / scale)))
        t.equal((dac.current_dac, dac.force_dac), (0, code), f"DAC codes with BIAS {bias}")


def rows_in_force(t: Tester) -> None:
    """Rows act at the SYNC that names their set, not before, and not those of another set."""
    t.operational(BARE)
    scale = t.parameters[Parameter.TORQUE_PER_CODE]

    def send(number: int, gravity: float) -> None:
        row = t.own_first([1.0, *[0.0] * 5])
        t.only(t.rows(number, (*row, *[0.0] * 6, gravity, number, 0, 0.0, 0, 0)), ())

    def torque(named: int) -> float:
        t.row_set = named
        dacs = t.run().of("DAC")
        t.equal(len(dacs), 1, "DAC frames")
        code: int = dacs[0].current_dac
        return code * scale

    t.near(torque(0), 0.0, scale, "torque before any set")
    send(7, 1.2)
    t.near(torque(0), 0.0, scale, "torque before SYNC names the set")
    t.near(torque(7), 1.2, scale, "torque with set 7")
    send(8, -0.9)
    t.near(torque(7), 1.2, scale, "torque while set 8 arrives")
    t.equal(t.state_is(S.OPERATIONAL).error_register, 0, "error register")
    t.near(torque(9), 1.2, scale, "torque when SYNC names a set that did not come")
    t.near(torque(8), -0.9, scale, "torque with set 8")
    send(255, 0.6)
    t.near(torque(255), 0.6, scale, "torque with set 255")
    send(1, 0.3)
    t.near(torque(1), 0.3, scale, "torque with set 1")
    # a master that starts over numbers its sets from the beginning
    t.command(Command.QUICKSTOP)
    t.command(Command.RESET)
    t.home()
    t.start()
    t.near(torque(0), 0.0, scale, "torque after RESET")
    send(1, 0.45)
    t.near(torque(1), 0.45, scale, "torque with the new set 1")
