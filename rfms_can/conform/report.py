"""What came of a suite: for programs, and as JUnit for CI."""

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from rfms_can.conform.outcome import Outcome, Verdict

_PASSED: Final = {Verdict.PASSED: True, Verdict.FAILED: False}


def failed(outcomes: Sequence[Outcome], *, required: bool = True) -> list[Outcome]:
    """Checks that failed, of those that are required or of the others."""
    return [o for o in outcomes if o.verdict is Verdict.FAILED and o.required is required]


def as_json(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Each check that ran or waits; ``passed`` is null where it did not run."""
    checks = [
        {
            "id": o.id,
            "class": o.kind,
            "required": o.required,
            "passed": _PASSED.get(o.verdict),
            "sent": o.sent,
            "got": o.got,
            "want": o.want,
        }
        for o in outcomes
    ]
    counts = [o.verdict for o in outcomes]
    return {
        "checks": checks,
        "passed": counts.count(Verdict.PASSED),
        "failed": counts.count(Verdict.FAILED),
    }


def write_junit(path: Path, joint: int, outcomes: Sequence[Outcome]) -> None:
    """One test case a check; a recommended check that fails is told, and counts as skipped."""
    suite = ET.Element("testsuite", name=f"rfms conform {joint}")
    for o in outcomes:
        case = ET.SubElement(
            suite,
            "testcase",
            classname=f"conform.joint_{joint}.{o.kind}",
            name=f"{o.id} {o.title}",
            time=f"{o.seconds:.3f}",
        )
        if o.verdict is Verdict.FAILED and o.required:
            failure = ET.SubElement(case, "failure", message=f"got {o.got}; want {o.want}")
            failure.text = f"sent {o.sent}\ngot  {o.got}\nwant {o.want}"
        elif o.verdict is not Verdict.PASSED:
            reason = f"recommended: got {o.got}" if o.verdict is Verdict.FAILED else o.got
            ET.SubElement(case, "skipped", message=reason)
    counts = {"tests": "testcase", "failures": "testcase/failure", "skipped": "testcase/skipped"}
    for name, tag in counts.items():
        suite.set(name, str(len(suite.findall(tag))))
    root = ET.Element("testsuites")
    root.append(suite)
    ET.indent(root)
    path.parent.mkdir(parents=True, exist_ok=True)
    ET.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
