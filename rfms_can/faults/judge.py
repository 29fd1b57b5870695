"""Whether a trial has met what its row asks: each rule gives its reason, or nothing.

A rule reads the facts of a trial and the variant; it knows nothing of nodes.
"""

from collections.abc import Callable
from typing import Final

from rfms_can.faults.facts import Facts
from rfms_can.faults.table import GOES_ON, HARDNESS, JOINT, Expected, Variant, Where
from rfms_can.tables import complete
from rfms_can.wire.nodes import NODE_NAMES

RESOLUTION: Final[dict[Where, float]] = complete({Where.SIM: 0.1, Where.PROCESSES: 0.5}, Where)
"""Cycles by which the instant of a reaction is known: on the simulated bus it is seen at the end of
a frame; among processes the kernel decides who runs when, and a cycle there is 0.2 s or more."""
SPEED: Final = 1.5
"""Largest speed over the limit: an amplifier that drives as it likes has a few cycles for it."""
STOPPED: Final = 2
"""Reaction from which on a node has stopped."""

Rule = Callable[[Variant, Facts], str]


def problems(variant: Variant, facts: Facts) -> list[str]:
    """Everything that a trial has not met, in words; empty if it has met its row."""
    rules = (*_RULES[variant.expected], *_ALWAYS)
    return [why for why in (rule(variant, facts) for rule in rules) if why]


def detection(variant: Variant, facts: Facts) -> float | None:
    """Cycles until the fault was found: counted where the motion goes on, else reacted to."""
    if variant.expected is Expected.REJECTED:
        return 0.0 if facts.refused else None
    if variant.expected in GOES_ON:
        return facts.counted
    if variant.expected is Expected.REFUSED:
        return None if facts.enabled else 0.0
    return facts.reached


def reaction_of(variant: Variant, facts: Facts) -> str:
    """What came of the fault, in the words of the table."""
    hardest = max(facts.reactions, default=0)
    if variant.expected is Expected.REFUSED:
        return "enabled" if facts.enabled else Expected.REFUSED.value
    if facts.refused:
        return Expected.REJECTED.value
    if hardest >= STOPPED:
        return f"R{hardest}"
    if facts.held:
        return Expected.R1.value
    return Expected.NONE.value if facts.counted is None else Expected.R0.value


def culprit_of(variant: Variant, facts: Facts) -> str:
    """Who has to be named; empty where nothing has to stop."""
    return NODE_NAMES[facts.node] if variant.culprit == JOINT else variant.culprit


def names_culprit(variant: Variant, facts: Facts) -> bool:
    """Whether the right one was named, or no one where nothing had to stop."""
    return facts.named == culprit_of(variant, facts)


# --- rules ----------------------------------------------------------------------------------------


def _has_effect(_: Variant, facts: Facts) -> str:
    without = facts.effect is None and facts.stopped is None
    return "the fault had no effect" if without else ""


def _found(variant: Variant, facts: Facts) -> str:
    cycles = detection(variant, facts)
    if cycles is None:
        return f"not found (bound {variant.bound:g} cycles)"
    if cycles > variant.bound + RESOLUTION[variant.where]:
        return f"found after {cycles:.1f} cycles, bound {variant.bound:g}"
    return ""


def _goes_on(_: Variant, facts: Facts) -> str:
    hardest = max(facts.reactions, default=0)
    return f"stopped with R{hardest}: {facts.told}" if hardest >= STOPPED else ""


def _all_stop(variant: Variant, facts: Facts) -> str:
    wanted = STOPPED if variant.culprit == JOINT else max(STOPPED, HARDNESS[variant.expected])
    if facts.others < wanted:
        return f"a joint that is sound reached R{facts.others}, not R{wanted}"
    return ""


def _comes_to_rest(_: Variant, facts: Facts) -> str:
    return "not at rest at the end" if facts.rest is None else ""


def _named(variant: Variant, facts: Facts) -> str:
    if names_culprit(variant, facts):
        return ""
    return f"blamed {facts.named or 'no one'} for {culprit_of(variant, facts) or 'nothing'}"


def _exit_code(variant: Variant, facts: Facts) -> str:
    wanted = 0 if variant.expected in GOES_ON else 1
    return "" if facts.exit_code == wanted else f"exit code {facts.exit_code}, not {wanted}"


def _rejected(_: Variant, facts: Facts) -> str:
    return "" if facts.refused else "the request was taken"


def _not_enabled(_: Variant, facts: Facts) -> str:
    return "the arm was enabled" if facts.enabled else ""


def _speed(_: Variant, facts: Facts) -> str:
    if facts.speed > SPEED:
        return f"a joint reached {facts.speed:.1f} times its speed limit"
    return ""


def _range(variant: Variant, facts: Facts) -> str:
    if facts.contact:
        return "a joint ran into its hard stop"
    if facts.past_range > 0.0 and variant.expected is not Expected.R4:
        return f"a joint was {facts.past_range:.3f} rad beyond its range"
    return ""


def _brakes(_: Variant, facts: Facts) -> str:
    if facts.brakes:
        joints = ", ".join(map(str, facts.brakes))
        return f"brakes of joints that are sound closed in motion: {joints}"
    return ""


def _reenabled(_: Variant, facts: Facts) -> str:
    return "; ".join(facts.reenabled)


def _none_left(_: Variant, facts: Facts) -> str:
    return f"processes were left behind: {', '.join(facts.left)}" if facts.left else ""


_ALWAYS: Final[tuple[Rule, ...]] = (
    *(_named, _exit_code, _speed, _range, _brakes, _reenabled),
    _none_left,
)
"""Rules of every trial."""
_ON: Final[tuple[Rule, ...]] = (_has_effect, _found, _goes_on)
_STOP: Final[tuple[Rule, ...]] = (_has_effect, _found, _all_stop)

_RULES: Final[dict[Expected, tuple[Rule, ...]]] = complete(
    {
        Expected.NONE: (_has_effect, _goes_on),
        Expected.R0: _ON,
        Expected.R1: _ON,
        Expected.R2: (*_STOP, _comes_to_rest),
        Expected.R3: _STOP,
        Expected.R4: (*_STOP, _comes_to_rest),
        Expected.REJECTED: (_rejected, _goes_on),
        Expected.REFUSED: (_not_enabled,),
    },
    Expected,
)
"""Rules by what has to come of a fault."""
