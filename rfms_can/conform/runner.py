"""Runs checks one after the other and says what came of each."""

import time
from collections.abc import Callable, Iterable, Iterator
from typing import Final

from rfms_can.conform.outcome import CheckFailed, CheckSkipped, NodeSilent, Outcome, Verdict
from rfms_can.conform.table import Check
from rfms_can.conform.tester import Tester

FATAL_SILENCES: Final = 3
"""Checks in a row in which the node said nothing, after which the suite gives up."""

OnCheck = Callable[[Check], None]


def run_checks(
    tester: Tester,
    checks: Iterable[Check],
    *,
    fail_fast: bool = False,
    begins: OnCheck = lambda _check: None,
) -> Iterator[Outcome]:
    """Run checks.

    Args:
        tester: on the node's line.
        checks: those asked for, in order.
        fail_fast: stop after the first required check that fails.
        begins: called as a check begins.
    """
    silences = 0
    for check in checks:
        begins(check)
        outcome, silent = _run(tester, check)
        yield outcome
        silences = silences + 1 if silent else 0
        failed = outcome.verdict is Verdict.FAILED and check.required
        if (fail_fast and failed) or silences >= FATAL_SILENCES:
            return


def _run(tester: Tester, check: Check) -> tuple[Outcome, bool]:
    """One check, and whether the node was silent."""
    if check.run is None:
        return _outcome(check, Verdict.PENDING, got=check.pending), False
    begin, sent, heard = time.monotonic(), tester.sent_frames, tester.heard_frames
    try:
        tester.greet()
        check.run(tester)
    except CheckSkipped as reason:
        return _outcome(check, Verdict.SKIPPED, got=str(reason)), False
    except CheckFailed as failure:
        told = (failure.sent, failure.got, failure.want)
        silent = isinstance(failure, NodeSilent)
        return _outcome(check, Verdict.FAILED, *told, seconds=time.monotonic() - begin), silent
    told = (
        f"{check.title}: {tester.sent_frames - sent} frames",
        f"as required: {tester.heard_frames - heard} frames",
        check.want,
    )
    return _outcome(check, Verdict.PASSED, *told, seconds=time.monotonic() - begin), False


def _outcome(
    check: Check,
    verdict: Verdict,
    sent: str = "",
    got: str = "",
    want: str = "",
    seconds: float = 0.0,
) -> Outcome:
    told = (sent or check.title, got, want or check.want)
    head = (check.id, check.title, check.kind.value, check.required)
    return Outcome(*head, verdict, *told, seconds)
