"""The judge of trials: a good trial passes, and each way to be wrong is told.

Facts that a judge could take for a success are made here one by one, and successes that look odd.
"""

import msgspec
import pytest

from rfms_can.faults.facts import Facts
from rfms_can.faults.judge import names_culprit, problems, reaction_of
from rfms_can.faults.table import Expected, State, Variant

STOPPED = Facts(
    node=3,
    injected=300,
    effect=0.4,
    counted=0.8,
    stopped=2.9,
    reached=2.9,
    halted=2.9,
    reactions=[2, 2, 2, 2, 2, 2],
    others=2,
    held=True,
    named="joint 3",
    told="joint 3: no ERROR_3 for 3 cycles",
    speed=0.55,
    rest=60.0,
    enabled=True,
    exit_code=1,
)
"""A controlled stop as it should be."""
WENT_ON = Facts(node=3, injected=300, effect=0.4, counted=0.8, held=True, enabled=True, speed=0.55)
"""A frame that was missed, and no more."""

R2 = Variant("", 3, Expected.R2, "joint")
R1 = Variant("", 1, Expected.R1)


def changed(facts: Facts, **values: object) -> Facts:
    return msgspec.structs.replace(facts, **values)


def test_good_trials_pass() -> None:
    assert problems(R2, STOPPED) == []
    assert problems(R1, WENT_ON) == []
    assert reaction_of(R2, STOPPED) == "R2"
    assert reaction_of(R1, WENT_ON) == "R1"


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"effect": None, "stopped": None}, "no effect"),
        ({"reached": None}, "not found"),
        ({"reached": 3.2}, "after 3.2 cycles, bound 3"),
        ({"others": 0}, "sound reached R0"),
        ({"others": 1}, "sound reached R1"),
        ({"rest": None}, "not at rest"),
        ({"named": "joint 4"}, "blamed joint 4 for joint 3"),
        ({"named": ""}, "blamed no one for joint 3"),
        ({"exit_code": 0}, "exit code 0"),
        ({"speed": 1.51}, "1.5 times its speed limit"),
        ({"contact": True}, "hard stop"),
        ({"past_range": 0.01}, "0.010 rad beyond its range"),
        ({"brakes": [1, 2]}, "closed in motion: 1, 2"),
        ({"reenabled": ["the brake of joint 3 opened again"]}, "brake of joint 3 opened"),
    ],
)
def test_false_successes_of_a_stop_are_told(values: dict[str, object], why: str) -> None:
    (told,) = problems(R2, changed(STOPPED, **values))
    assert why in told


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"effect": None}, "no effect"),
        ({"counted": None}, "not found"),
        ({"counted": 1.2}, "bound 1"),
        ({"reactions": [0, 0, 2, 0, 0, 0]}, "stopped with R2"),
        ({"named": "joint 3"}, "for nothing"),
        ({"exit_code": 1}, "exit code 1, not 0"),
        ({"speed": 1.51}, "speed limit"),
    ],
)
def test_false_successes_of_a_motion_that_goes_on_are_told(
    values: dict[str, object], why: str
) -> None:
    (told,) = problems(R1, changed(WENT_ON, **values))
    assert why in told


def test_odd_successes_pass() -> None:
    on_the_bound = changed(STOPPED, reached=3.05)  # seen at the end of a frame
    assert problems(R2, on_the_bound) == []
    before_its_effect = changed(STOPPED, effect=None, stopped=0.0, reached=0.0)
    assert problems(R2, before_its_effect) == []
    harder_at_fault = changed(STOPPED, reactions=[2, 2, 4, 2, 2, 2])
    assert problems(R2, harder_at_fault) == []
    deaf = changed(STOPPED, reactions=[2, 2, 0, 2, 2, 2])  # the joint at fault cannot react
    assert problems(R2, deaf) == []


def test_a_hard_reaction_of_all_is_asked_of_all() -> None:
    off = Variant("", 3, Expected.R4, "plant")
    all_off = changed(STOPPED, named="plant", reactions=[4] * 6, others=4)
    assert problems(off, all_off) == []
    (told,) = problems(off, changed(all_off, others=2))
    assert "sound reached R2, not R4" in told
    of_one = Variant("", 3, Expected.R4, "joint")
    assert problems(of_one, changed(STOPPED, reactions=[2, 2, 4, 2, 2, 2])) == []


def test_requests_must_be_refused_and_the_motion_go_on() -> None:
    asked = Variant("", 0, Expected.REJECTED)
    refused = changed(WENT_ON, counted=None, held=False, refused="out of reach")
    assert problems(asked, refused) == []
    assert reaction_of(asked, refused) == "reject"
    assert problems(asked, changed(refused, refused="")) == ["the request was taken"]
    (told,) = problems(asked, changed(refused, reactions=[2] * 6))
    assert "stopped" in told


def test_an_arm_that_must_not_be_enabled() -> None:
    at_start = Variant("", 0, Expected.REFUSED, "joint", State.START)
    named = Facts(node=3, injected=-1, effect=None, named="joint 3", exit_code=1)
    assert problems(at_start, named) == []
    assert reaction_of(at_start, named) == "refuse"
    enabled = changed(named, enabled=True)
    assert problems(at_start, enabled) == ["the arm was enabled"]
    assert reaction_of(at_start, enabled) == "enabled"


def test_nothing_may_come_of_some_faults() -> None:
    nothing = Variant("", 0, Expected.NONE)
    assert problems(nothing, changed(WENT_ON, counted=None)) == []
    (told,) = problems(nothing, changed(WENT_ON, reactions=[2] * 6))
    assert "stopped" in told


def test_a_foreign_sender_is_the_culprit_or_is_not_named() -> None:
    foreign = Variant("", 3, Expected.R2, "foreign")
    words = "foreign frames fill the bus"
    assert names_culprit(foreign, changed(STOPPED, named="foreign", told=words))
    assert not names_culprit(foreign, changed(STOPPED, told=words))  # blamed is joint 3
    assert not names_culprit(foreign, STOPPED)
