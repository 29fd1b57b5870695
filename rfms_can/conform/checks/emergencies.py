"""What an EMCY must say, for all checks that provoke one."""

from typing import Final

from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

FREE: Final = {Parameter.SPEED_LIMIT: 100.0}
"""For checks whose joint is where it is asked for, whatever its tachometer tells."""


def emergency(
    t: Tester,
    answers: Answers,
    fault: FaultCode,
    *,
    culprit: int,
    frame: int,
    value: float,
    bound: float,
    others: tuple[FaultCode, ...] = (),
    tolerance: float = 1e-6,
) -> None:
    """One EMCY among answers, to the digit; ``others``: faults noted before."""
    found = answers.of("EMCY")
    t.equal([FaultCode(e.fault).name for e in found], [fault.name], "EMCY")
    (told,) = found
    t.equal((told.culprit, told.frame), (culprit, frame), f"culprit and frame of {fault.name}")
    t.near(told.value, value, tolerance * max(1.0, abs(value)), f"value of {fault.name}")
    t.near(told.bound, bound, 1e-6 * max(1.0, abs(bound)), f"bound of {fault.name}")
    t.equal(told.error_register, register(fault, *others), f"error register of {fault.name}")
    t.equal(told.cycle, t.last_cycle & 0xFF, f"cycle of {fault.name}")


def register(*faults: FaultCode) -> int:
    """The error register with these faults in it."""
    bits = 0
    for fault in faults:
        bits |= 1 << fault | 1
    return bits


def noted(t: Tester, state: NodeState, *faults: FaultCode) -> None:
    """State and error register of the HEARTBEAT now."""
    beat = t.state_is(state)
    t.equal(beat.error_register, register(*faults), "error register")


def off(t: Tester, answers: Answers, names: tuple[str, ...] = ("EMCY", "DAC")) -> None:
    """An EMCY, and then one DAC of zero."""
    t.only(Answers(h for h in answers if h.name != "HEARTBEAT"), names)
    for dac in answers.of("DAC"):
        t.equal((dac.current_dac, dac.force_dac), (0, 0), "DAC codes when torque goes off")


def silent(t: Tester, cycles: int = 3) -> None:
    """Nothing more comes, whatever the others do."""
    for _ in range(cycles):
        answers = t.run()
        t.only(Answers(h for h in answers if h.name != "HEARTBEAT"), (), "after torque off")


def count(t: Tester) -> float:
    """One encoder count, rad."""
    return 1.0 / abs(t.parameters[Parameter.COUNTS_PER_UNIT])


def no_more_than(t: Tester) -> float:
    """A speed that is no error of a rate, however the set-point stands, rad/s."""
    p = t.parameters
    return 0.9 * p[Parameter.RATE_ERROR_LIMIT] * p[Parameter.SPEED_LIMIT]


def step_limit(t: Tester) -> float:
    """Largest step of a set-point or an encoder in a cycle, rad."""
    p = t.parameters
    return 1.5 * p[Parameter.SPEED_LIMIT] * p[Parameter.PERIOD]
