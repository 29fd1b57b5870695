"""Plays a trace of ``vectors/`` to the node, cycle by cycle.

What a cycle does not name stays as it was, but for what happens once (``ONCE``).
"""

from collections.abc import Iterator
from typing import Any, Final

from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.contract import BIAS_BELONGS, COMPLY_BELONGS, JOINT_SETPOINT_BELONGS
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Bias, Comply, Setpoint
from rfms_can.wire.vocabulary import (
    Blend,
    Command,
    Law,
    Mode,
    NodeState,
    Parameter,
    TrajectoryState,
)

Trace = dict[str, Any]
Cycle = dict[str, Any]

ONCE: Final = ("command", "omit", "skip", "second")
"""Inputs of one cycle only."""
AT_REST: Final[Cycle] = {
    "sync": "OPERATIONAL",
    "state": "IDLE",
    "mode": "JOINT",
    "blend": "CONTINUOUS",
    "r": 0.0,
    "p": 0.0,
    "acceleration_time": 0.2,
    "others": [[0.0, 0.0, 0.0]] * 5,
    "speed": 0.0,
    "comply": None,
    "bias": None,
    "rows": None,
    "index": None,
}
"""Inputs before the first cycle, beside ``angle`` and ``measured``, which are ``begin``."""
_NO_ROW: Final = [0.0] * 6


def play(t: Tester, trace: Trace) -> Iterator[tuple[Cycle, Answers]]:
    """Bring the node to where the trace begins; then each cycle, and what the node sent in it."""
    changes = {Parameter[name]: value for name, value in trace.get("changes", {}).items()}
    begin = trace.get("begin", 0.0)
    bring = {"PREOP": t.unreferenced, "READY": t.ready, "OPERATIONAL": t.operational}
    bring[trace.get("from", "OPERATIONAL")](changes, begin)
    now: Cycle = {**AT_REST, "angle": t.measured, "measured": begin, "coarse": begin}
    rows = None
    for cycle in trace["cycles"]:
        now = {**{k: v for k, v in now.items() if k not in ONCE}, **cycle}
        answers = Answers()
        if "command" in now:
            answers += _command(t, now["command"])
        if now["rows"] is not rows:
            rows = now["rows"]
            answers += _send_rows(t, rows)
        yield now, answers + _cycle(t, now)


def _command(t: Tester, name: str) -> Answers:
    command = Command[name]
    if command is Command.START:
        return t.start()
    return t.command(command)


def _cycle(t: Tester, now: Cycle) -> Answers:
    """The frames of one cycle."""
    omit = now.get("omit", ())
    t.theta, t.speed = now["measured"], now["speed"]
    answers = t.sync(NodeState[now["sync"]], skip=now.get("skip", 0))
    if now["sync"] == "OPERATIONAL" and "SETPOINT" not in omit:
        answers += _setpoint(t, now)
    if "MEASURE" not in omit:
        answers += t.measure()
    if now["sync"] == "HOMING" and "REFERENCE" not in omit:
        answers += _reference(t, now)
    if now["sync"] == "OPERATIONAL":
        silent = [t.others()[int(word[-1])][0] for word in omit if word.startswith("ERROR")]
        answers += t.errors(now["others"], without=silent)
    return answers


def _setpoint(t: Tester, now: Cycle) -> Answers:
    """SETPOINT_1, and what belongs to it."""
    rest = t.vectors.rest_pose
    second = now.get("second")
    extras = JOINT_SETPOINT_BELONGS
    extras |= 0 if now["comply"] is None else COMPLY_BELONGS
    extras |= 0 if now["bias"] is None else BIAS_BELONGS
    poses = 1 if second is None else 2
    values = (
        *(*rest.o, *rest.a, *rest.p, now["r"], now["p"], now["acceleration_time"]),
        *(TrajectoryState[now["state"]], Mode[now["mode"]], rest.configuration),
        *(Blend[now["blend"]], t.cycle, 1, poses, extras),
    )
    frames = [t.frame(Setpoint, number, *values) for number in range(1, poses + 1)]
    frames.append(t.angles_frame(now["angle"]))
    if second is not None:
        frames.append(t.angles_frame(second, 2))
    for record, name in ((Comply, "comply"), (Bias, "bias")):
        if now[name] is not None:
            own = [0.01 * j for j in JOINTS]  # those of the others, which are not for this joint
            own[t.index] = now[name]
            frames.append(t.frame(record, None, *own, t.cycle & 0xFF))
    return t.give(*frames)


def _reference(t: Tester, now: Cycle) -> Answers:
    index = now["index"]
    code = t.coarse_code(now["coarse"])
    if index is None:
        return t.reference(valid=0, coarse=code, index_counts=0)
    return t.reference(coarse=code, index_counts=t.counts(index))


def _send_rows(t: Tester, rows: dict[str, Any] | None) -> Answers:
    """ROWS: in a trace the own joint's element stands first."""
    told = rows or {}
    law = t.own_first(told.get("law_row", [1.0, *_NO_ROW[1:]]))
    inertia = t.own_first(told.get("inertia_row", _NO_ROW))
    number = t.row_set % 255 + 1
    values = (
        *(*law, *inertia, told.get("gravity", 0.0), number, Law[told.get("law", "PID")]),
        *(told.get("damping", 0.0), told.get("selection", 0), told.get("specification", 0)),
    )
    return t.rows(number, values)
