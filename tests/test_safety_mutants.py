"""Mutants of the safety core: names that stay, what has changed, a few killed, and the campaign."""

import ast
from pathlib import Path

import pytest
from node_mutants import population as made
from node_mutants import trial as fates
from node_mutants.mutant import Mutant, source_of
from node_mutants.survivors import EQUIVALENT, GAP
from safety_mutants import changed, population, table, trial
from safety_mutants.core import CORE, FOLDER, LEFT_OUT, NOT_CORE, path_of_test
from safety_mutants.operators import OPERATORS
from safety_mutants.owners import MODULE, fingerprints, owners
from safety_mutants.population import cases_of, sample
from safety_mutants.results import KEPT, SAFETY, Conditions, Tried, opened
from safety_mutants.survivors import SURVIVED_FOR

from rfms_can.errors import RfmsError

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "rfms_can"
WATCHDOG = "plant/brake_watchdog.py"


# --- the core -------------------------------------------------------------------------------------


def test_every_file_of_the_joint_is_in_the_core_or_has_a_reason_not_to_be() -> None:
    files = {p.relative_to(PACKAGE).as_posix() for p in (PACKAGE / FOLDER).rglob("*.py")}
    assert files == {file for file in CORE if file.startswith(FOLDER)} | set(NOT_CORE)
    assert all(NOT_CORE.values())


@pytest.mark.parametrize("file", CORE)
def test_files_of_the_core_and_their_tests_exist(file: str) -> None:
    assert (PACKAGE / file).is_file()
    assert CORE[file] and len(set(CORE[file])) == len(CORE[file])
    assert [name for name in CORE[file] if not path_of_test(name).is_file()] == []


def test_what_is_left_out_is_in_the_code() -> None:
    for file, names in LEFT_OUT.items():
        nodes = ast.walk(ast.parse(source_of(file)))
        assert names <= {n.name for n in nodes if isinstance(n, ast.FunctionDef)}, file


def test_every_mutant_has_a_name_of_its_own_and_every_operator_mutants() -> None:
    cases = population.population()
    assert len({case.mutant.name for case in cases}) == len(cases) > 2500
    assert {case.mutant.kind for case in cases} == set(OPERATORS)
    assert {case.mutant.file for case in cases} == set(CORE)


@pytest.mark.parametrize("file", [WATCHDOG, "joint_nodes/states.py"])
def test_each_mutant_is_a_program_that_is_another(file: str) -> None:
    whole = ast.dump(ast.parse(source_of(file)))
    for case in cases_of(file):
        assert ast.dump(ast.parse(case.mutant.source)) != whole, case.mutant.name


# --- names and fingerprints -----------------------------------------------------------------------

SOURCE = '''"""A file."""

BOUND = 3


class Watch:
    """Watches."""

    limit = 1

    def see(self, x: int) -> bool:
        # why
        return x > BOUND
'''


def test_a_line_is_of_the_innermost_function_or_class() -> None:
    told = owners(SOURCE)
    assert [told[n] for n in (2, 5, 8, 11, 12)] == [MODULE, "Watch", "Watch", *2 * ["Watch.see"]]


@pytest.mark.parametrize(
    ("before", "after", "functions"),
    [
        ("# why", "# because", set()),
        ("BOUND = 3\n", "\n\nBOUND = 3\n", set()),
        ("x > BOUND", "x >= BOUND", {"Watch.see"}),
        ("limit = 1", "limit = 2", {"Watch"}),
        ("BOUND = 3", "BOUND = 4", {MODULE}),
    ],
)
def test_a_fingerprint_is_of_what_a_function_says(
    before: str, after: str, functions: set[str]
) -> None:
    then, now = fingerprints(SOURCE), fingerprints(SOURCE.replace(before, after))
    assert {name for name in then if then[name] != now[name]} == functions


def test_names_stay_when_lines_move_and_go_when_the_line_changes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def names(text: str) -> dict[str, int]:
        for module in (population, made):
            monkeypatch.setattr(module, "source_of", lambda _: text)
        return {case.mutant.name: case.mutant.line for case in cases_of(WATCHDOG)}

    text = source_of(WATCHDOG)
    as_it_is, moved = names(text), names('"""Three\n\n\nlines."""\n' + text)
    assert set(as_it_is) == set(moved)
    assert all(moved[name] == as_it_is[name] + 4 for name in moved)
    bound = "SILENT_CYCLES: Final = 3"
    gone = set(as_it_is) - set(names(text.replace(bound, "SILENT_CYCLES: Final = 5 - 2")))
    assert gone and all(f"{WATCHDOG} {MODULE} constant" in name for name in gone)


# --- a few of them --------------------------------------------------------------------------------


def changed_text(before: str, after: str) -> Mutant:
    text = source_of(WATCHDOG)
    assert text.count(before) == 1
    return Mutant("a test's", WATCHDOG, 1, "by hand", before, after, text.index(before))


@pytest.mark.parametrize(
    ("before", "after", "verdict"),
    [
        ("SILENT_CYCLES: Final = 3", "SILENT_CYCLES: Final = 4 - 1", fates.SURVIVED),
        ("self._silent[board] += 1", "self._silent[board] += 2", fates.KILLED),
        ("SILENT_CYCLES: Final = 3", "SILENT_CYCLES: Final = 3 / 0", fates.RAISED),
    ],
)
def test_what_becomes_of_a_mutant(before: str, after: str, verdict: str) -> None:
    fate = trial.fate_of(changed_text(before, after))
    assert fate.verdict == verdict, fate
    assert ("::" in fate.test) == (verdict == fates.KILLED)


def test_a_mutant_that_hangs_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial, "CPU_S", 3)
    endless = changed_text("self._silent[board] += 1", "\n            while True: pass")
    assert trial.fate_of(endless).verdict == fates.TIMEOUT


def test_tests_that_fail_with_the_code_as_it_is_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    (tests,) = trial.to_be_sound([WATCHDOG])
    assert trial.sound(tests) == tests == tuple(sorted(CORE[WATCHDOG]))
    monkeypatch.setitem(CORE, WATCHDOG, ("test_no_such_file",))
    with pytest.raises(RfmsError, match=r"test_no_such_file fails with the code as it is"):
        trial.sound(*trial.to_be_sound([WATCHDOG]))


def test_each_test_is_run_once_with_the_code_as_it_is() -> None:
    names = [name for tests in trial.to_be_sound(CORE) for name in tests]
    assert names == sorted({name for tests in CORE.values() for name in tests})


# --- what has changed -----------------------------------------------------------------------------


def conditions(function: str = "a", tests: str = "t") -> Conditions:
    return Conditions(1, 9, {"f.py": {"one": function, "two": "b"}}, {"f.py": tests})


def test_functions_that_changed_and_files_whose_tests_did() -> None:
    then = conditions()
    assert changed.changed(then, conditions()) == {}
    assert changed.changed(then, conditions("other")) == {"f.py": {"one"}}
    assert changed.changed(then, conditions(tests="other")) == {"f.py": {"one", "two"}}
    assert changed.changed(then._replace(functions={}), then) == {"f.py": {"one", "two"}}


def test_mutants_of_what_changed_alone_are_drawn() -> None:
    found = {WATCHDOG: frozenset({"BrakeWatchdog.reset", "BrakeWatchdog.lost"})}
    cases = changed.cases_of_changed(found)
    assert {case.function for case in cases} == found[WATCHDOG]
    assert (
        len(
            changed.cases_of_changed(
                {file: frozenset(population.functions_of(file)) for file in CORE}
            )
        )
        == changed.SAMPLE
    )
    assert changed.cases_of_changed({}) == []


def result(verdict: str, name: str = "x") -> Tried:
    return Tried(name, "f.py", "one", "branch", "a", "b", "c", "d", verdict, "", "")


@pytest.mark.parametrize(
    ("killed", "survived", "well"),
    [(2, 1, True), (18, 1, True), (1, 2, False), (17, 2, False), (38, 2, True), (37, 3, False)],
)
def test_95_of_100_are_wanted_and_of_fewer_than_20_all_but_one(
    killed: int, survived: int, well: bool
) -> None:
    results = [result(fates.KILLED)] * killed + [result(fates.SURVIVED)] * survived
    assert table.are_killed(results) == well
    told, lines = changed.verdict([*sample(1, len(results))], results)
    assert told == well
    assert len(lines) == survived + 1 and lines[0].startswith("survived: x: a -> b")


def test_equivalents_do_not_count_and_hanging_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SURVIVED_FOR, "same", (EQUIVALENT, "why"))
    results = [result(fates.SURVIVED, "same")] * 9 + [result(fates.TIMEOUT)]
    assert (len(table.judged(results)), table.survivors(results)) == (1, [])


def test_too_few_for_a_verdict_is_no_verdict() -> None:
    well, lines = changed.verdict(sample(1, 40), [result(fates.KILLED)] * 10)
    assert not well and "too few for a verdict" in lines[-1]


def test_results_that_may_be_others_now_are_made_again_and_the_rest_is_taken_over(
    tmp_path: Path,
) -> None:
    file, cases = tmp_path / "kept.jsonl", sample(1, 5)
    results = [Tried.of(case, trial.Fate(fates.KILLED)) for case in cases]
    results[1] = results[1]._replace(code="of other code")
    results[2] = results[2]._replace(tests="other tests")
    results[3] = results[3]._replace(verdict=fates.SURVIVED)
    name = CORE[cases[4].mutant.file][-1]
    results[4] = Tried.of(cases[4], trial.Fate(fates.KILLED, f"{name}.py::test_it"))
    assert results[4].tests not in (results[0].tests, Tried.of(cases[4], trial.Fate("")).tests)
    SAFETY.write(file, conditions(), results)
    kept = opened(file, Conditions.here(1), cases, frozenset({fates.SURVIVED}))
    assert kept.results == [results[0], results[4]]
    assert SAFETY.read(file) == (Conditions.here(1), [results[0], results[4]])


# --- the campaign ---------------------------------------------------------------------------------


def test_the_tests_kill_95_of_100() -> None:
    told, results = SAFETY.read(ROOT / KEPT)
    assert len(results) >= 300
    assert told.population > 2500
    survived, judged = len(table.survivors(results)), len(table.judged(results))
    assert survived <= 0.05 * judged, f"{survived} of {judged} survived"


def test_every_survivor_has_a_reason_and_every_reason_a_survivor() -> None:
    _, results = SAFETY.read(ROOT / KEPT)
    by_verdict = {r.name: r.verdict for r in results}
    survived = {name for name, verdict in by_verdict.items() if verdict == fates.SURVIVED}
    assert survived <= set(SURVIVED_FOR)
    killed = set(by_verdict) - survived
    assert not set(SURVIVED_FOR) & killed
    assert all(word in (EQUIVALENT, GAP) and why for word, why in SURVIVED_FOR.values())
