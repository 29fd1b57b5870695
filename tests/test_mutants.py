"""Mutants of the joint node: a few are killed here, and the campaigns that are kept hold."""

import ast
from pathlib import Path

import pytest
from node_mutants import in_runs, table, trial
from node_mutants.apart import apart
from node_mutants.hand import BY_HAND, by_hand
from node_mutants.loading import joint_of
from node_mutants.mutant import Mutant
from node_mutants.operators import OPERATORS
from node_mutants.population import FILES, NOT_OF_A_JOINT, mutants_of, population, sample
from node_mutants.results import KEPT, KEPT_RUNS, read, read_runs
from node_mutants.survivors import EQUIVALENT, GAP, MISSED, SURVIVED_FOR
from node_mutants.trial import KILLED, RAISED, TIMEOUT, Fate, fate_of

from rfms_can.joint_nodes.joint import JointNode
from rfms_can.wire.protection import Receiver

ROOT = Path(__file__).parents[1]
HAND = {mutant.name: mutant for mutant in by_hand()}


def changed(file: str, before: str, after: str) -> Mutant:
    text = (ROOT / "rfms_can" / file).read_text(encoding="utf-8")
    return Mutant("a test's", file, 1, BY_HAND, before, after, text.index(before))


# --- a few of them --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "check"),
    [
        ("sent counters begin at 1", "1"),
        ("the hash of a configuration starts from 0", "12"),
        ("the sign of the index count", "1b"),
        ("HEARTBEAT a cycle late", "1b"),
        ("old errors of the others are used", "28"),
        ("a missing rung: no damping where set-points are missing", "35"),
        ("a runaway is seen after nine cycles", "40f"),
    ],
)
def test_mistakes_by_hand_are_killed(name: str, check: str) -> None:
    fate = fate_of(HAND[name])
    assert (fate.verdict, fate.joint) == (KILLED, 3)
    assert fate.check == check


@pytest.mark.system
def test_the_code_as_it_is_survives() -> None:
    assert fate_of(None).verdict == trial.SURVIVED


def test_a_mutant_that_raises_is_told_apart() -> None:
    broken = changed("joint_nodes/servo.py", "DAC_MIN: Final = -2048", "DAC_MIN: Final = -2048 / 0")
    assert fate_of(broken) == Fate(RAISED, "", 3, "ZeroDivisionError: division by zero")


def test_a_mutant_that_hangs_is_ended() -> None:
    def hangs() -> Fate:
        while True:
            pass

    assert apart(hangs, cpu_s=1) is None


def test_mutants_are_apart_from_the_code_as_it_is() -> None:
    wrong = changed("wire/protection.py", "COUNTER_WINDOW: Final = 16", "COUNTER_WINDOW: Final = 1")
    node = joint_of(wrong)(3, 1)
    assert type(node) is not JointNode
    assert not any(isinstance(receiver, Receiver) for receiver in node._receivers)  # type: ignore[attr-defined]
    import rfms_can.joint_nodes.joint as whole

    assert whole.JointNode is JointNode
    assert type(joint_of(None)(3, 1)).__name__ == "JointNode"


# --- the operators --------------------------------------------------------------------------------


def test_every_operator_has_mutants_of_every_kind_of_file() -> None:
    assert {mutant.kind for mutant in population()} == set(OPERATORS)
    assert {mutant.file for mutant in population()} <= set(FILES)
    assert len({mutant.name for mutant in population()}) == len(population())


@pytest.mark.parametrize("file", ["kinematics/limits.py", "setpoint/history.py"])
def test_each_mutant_is_a_program_that_is_another(file: str) -> None:
    text = (ROOT / "rfms_can" / file).read_text(encoding="utf-8")
    whole = ast.dump(ast.parse(text))
    for mutant in mutants_of(file):
        assert ast.dump(ast.parse(mutant.source)) != whole, mutant.name


def test_a_sample_is_drawn_by_its_seed() -> None:
    assert sample(1, 20) == sample(1, 20) != sample(2, 20)


def test_what_is_left_out_is_in_the_code() -> None:
    for file, names in NOT_OF_A_JOINT.items():
        tree = ast.parse((ROOT / "rfms_can" / file).read_text(encoding="utf-8"))
        kinds = (ast.FunctionDef, ast.ClassDef)
        assert names <= {node.name for node in ast.walk(tree) if isinstance(node, kinds)}, file


def test_mistakes_by_hand_are_in_the_code_and_are_programs() -> None:
    assert len(HAND) == len(by_hand()) >= 60
    for mutant in HAND.values():
        ast.parse(mutant.source)


# --- the campaigns --------------------------------------------------------------------------------


def test_the_suite_kills_95_of_100() -> None:
    conditions, results = read(ROOT / KEPT)
    drawn = [r for r in results if r.kind != BY_HAND]
    hand = [r for r in results if r.kind == BY_HAND]
    assert len(drawn) >= 300 and len(hand) >= 60
    assert conditions.population > 4000
    for group in (drawn, hand):
        killed, judged = table.killed_of(group)
        assert killed >= 0.95 * judged, f"{killed} of {judged}"


def test_every_survivor_has_a_reason() -> None:
    _, results = read(ROOT / KEPT)
    survived = {r.name for r in results if r.verdict in (trial.SURVIVED, TIMEOUT)}
    assert survived and survived <= set(SURVIVED_FOR)


def test_what_is_judged_is_a_mutant_that_no_check_has_killed_and_has_a_reason() -> None:
    _, results = read(ROOT / KEPT)
    gone = {r.name for r in results if r.verdict not in (trial.SURVIVED, TIMEOUT)}
    assert not set(SURVIVED_FOR) & gone
    assert set(SURVIVED_FOR) <= {mutant.name for mutant in population()} | set(HAND)
    assert all(word in (EQUIVALENT, GAP) and why for word, why in SURVIVED_FOR.values())


def test_no_mutant_moves_the_arm_wrongly_and_goes_on() -> None:
    _, runs = read_runs(ROOT / KEPT_RUNS)
    assert len(runs) >= 160
    found, wrong = table.found_of(runs)
    assert found >= 0.9 * wrong, f"{found} of {wrong}"
    assert sum(r.how == in_runs.NAMED for r in runs) >= 20
    finished = [r.name for r in runs if table.is_wrong(r) and r.how == in_runs.FINISHED]
    assert set(finished) <= set(MISSED)


# --- in runs --------------------------------------------------------------------------------------


@pytest.mark.system
@pytest.mark.parametrize(
    ("name", "how"),
    [
        (None, in_runs.FINISHED),
        ("a mirrored inverse solution", in_runs.NAMED),
        ("the sign of a joint segment", in_runs.NAMED),
        ("the sign of the error", in_runs.NAMED),
    ],
)
def test_a_mutant_in_a_run(name: str | None, how: str) -> None:
    ended = in_runs.run_of(None if name is None else HAND[name], 3)
    assert ended.how == how, ended.told
    assert ended.worst < in_runs.WRONG_RAD
