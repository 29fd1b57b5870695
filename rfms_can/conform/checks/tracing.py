"""Checks 29 and 30, and what goes with them: traces of ``vectors/``, cycle by cycle."""

from collections.abc import Callable
from typing import Any, Final

from rfms_can.conform.play import play
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.records import Dac, JointError
from rfms_can.wire.vocabulary import FaultCode, NodeState, Parameter

ANGLE: Final = 1e-6
"""Tolerance of a commanded angle, rad."""
SPEED: Final = 1e-3
"""Of its rate, rad/s."""
ACCELERATION: Final = 0.1
"""Of its acceleration, rad/s2."""
CODES: Final = 1.5
"""Of a DAC, against the torque before it is rounded: a code for the rates of a moving set-point."""
NEAREST: Final = 0.6
"""The same where no set-point has moved since START, and of the force DAC: the nearest code."""

TIMED: Final = 1 << FaultCode.SYNC_MISSING | 1
"""Bits of the error register that depend on the clock where SYNC leaves numbers out."""


def traces_of(file: str) -> Callable[[Tester], None]:
    """A check that plays all traces of a file."""

    def run(t: Tester) -> None:
        for trace in t.vectors.traces(file):
            play_one(t, trace)

    return run


def play_one(t: Tester, trace: dict[str, Any]) -> None:
    """One trace: what the node sends in each cycle must be what the trace says."""
    wanted: list[str] = ["ERROR", "DAC"]
    codes, before = NEAREST, None
    for number, (cycle, answers) in enumerate(play(t, trace)):
        where = f"{trace['name']}, cycle {number}:"
        wanted = cycle.get("sends", wanted)
        if before is not None and cycle["angle"] != before["angle"]:
            codes = CODES
        before = cycle
        came = Answers(h for h in answers if h.name != "HEARTBEAT")
        t.only(came, [w.partition(" ")[0] for w in wanted], where)
        faults = [FaultCode(e.fault).name for e in came.of("EMCY")]
        t.equal(faults, [w.partition(" ")[2] for w in wanted if w.startswith("EMCY")], where)
        for error in came.of("ERROR"):
            _error(t, error, cycle["error"], where)
        for dac in came.of("DAC"):
            if "torque" in cycle:
                _dac(t, dac, cycle["torque"], cycle["force"], codes, where)
            tags = {t.sampled, *((t.sampled_before,) if faults else ())}
            t.equal(dac.cycle in tags, True, f"{where} DAC tagged {dac.cycle}, one of {tags}")
        _beat(t, cycle, where)


def _beat(t: Tester, cycle: dict[str, Any], where: str) -> None:
    """State and faults, from the first cycle on that tells them."""
    if "becomes" not in cycle and "register" not in cycle:
        return
    beat = t.beat()
    if "becomes" in cycle:
        t.equal(NodeState(beat.state).name, cycle["becomes"], f"{where} state")
    if "register" in cycle:
        register = beat.error_register & ~TIMED
        t.equal(f"{register:#x}", f"{cycle['register']:#x}", f"{where} error register")


def _error(t: Tester, got: JointError, want: list[float], where: str) -> None:
    t.near(got.error, want[0], ANGLE, f"{where} error")
    t.near(got.error_rate, want[1], SPEED, f"{where} error rate")
    t.near(got.acceleration, want[2], ACCELERATION, f"{where} acceleration")
    t.equal(got.cycle, t.cycle & 0xFF, f"{where} cycle of ERROR")


def _dac(t: Tester, got: Dac, torque: float, force: float, codes: float, where: str) -> None:
    p = t.parameters
    for name, code, value, scale, within in (
        ("current DAC", got.current_dac, torque, p[Parameter.TORQUE_PER_CODE], codes),
        ("force DAC", got.force_dac, force, p[Parameter.TORQUE_PER_FORCE_CODE], NEAREST),
    ):
        want = max(-2048.0, min(2047.0, value / scale))
        t.near(code, want, within if value else 0.0, f"{where} {name}")
