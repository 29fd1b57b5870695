"""``rfms kin``: every line its own answer, and the stream goes on."""

import json
import math
from typing import Any

import pytest
import typer
from support.golden import distance, golden
from typer.testing import CliRunner

from rfms_can.arm import PUMA_260, PUMA_560
from rfms_can.cli.kin import answer, kin
from rfms_can.kinematics import direct, jacobian
from rfms_can.transform import Transform

Q = [0.3, 1.1, -0.7, 0.5, 0.9, -0.4]
POSE = direct(PUMA_260, Q).rows()
FOLDED = direct(PUMA_260, [*Q[:4], 2.5, Q[5]]).rows()


def ask(verb: str, **line: object) -> dict[str, Any]:
    reply: dict[str, Any] = json.loads(answer(verb, PUMA_260, json.dumps(line)))
    return reply


def test_answers_have_every_digit() -> None:
    assert ask("fk", q=Q) == {"T6": POSE}
    assert ask("jacobian", q=Q) == {"J": [list(row) for row in jacobian(PUMA_260, Q)]}
    found = ask("ik", T6=POSE, config="noflip left up")
    assert found.keys() == {"q"}
    assert distance(direct(PUMA_260, found["q"]), direct(PUMA_260, Q)) < 1e-14


def test_ik_takes_left_up_noflip_unless_told() -> None:
    assert ask("ik", T6=POSE) == ask("ik", T6=POSE, config="left up noflip")
    assert ask("ik", T6=POSE) != ask("ik", T6=POSE, config="left up flip")


def test_all_reference_branches_in_range_are_found() -> None:
    found = 0
    for case in golden("puma560_kinematics")["reachable"]:
        for branch in case["branches"]:
            if all(branch["within_limits"]):
                line = json.dumps({"T6": case["T6"], "config": branch["configuration"]})
                q = json.loads(answer("ik", PUMA_560, line))["q"]
                reached = direct(PUMA_560, q)
                assert distance(reached, Transform.from_rows(case["T6"])) < 1e-11
                found += 1
    assert found > 200


def test_a_singular_wrist_is_answered_with_a_warning() -> None:
    pose = direct(PUMA_260, [0.3, 1.1, -0.7, 0.0, 0.0, 0.2])
    reply = ask("ik", T6=pose.rows(), config="left up noflip")
    assert reply["q"][3:] == pytest.approx([0.0, 0.0, 0.2])
    assert "wrist singularity" in str(reply["warning"])


@pytest.mark.parametrize(
    ("verb", "line", "says"),
    [
        ("fk", "{", "truncated"),
        ("fk", "no JSON", "malformed"),
        ("fk", b"\xff\xfe", "malformed"),
        ("fk", "[" * 100_000, "Expected `object`"),
        ("fk", '{"q": [1, 2, 3]}', "length 6"),
        ("fk", '{"q": [1, 2, 3, 4, 5, NaN]}', "malformed"),
        ("fk", '{"q": [1, 2, 3, 4, 5, Infinity]}', "malformed"),
        ("fk", '{"q": [1, 2, 3, 4, 5, 1e999]}', "out of range"),
        ("fk", '{"q": [1, 2, 3, 4, 5, 1e300]}', "<= 1000000.0"),
        ("fk", '{"q": [1, 2, 3, 4, 5, "6"]}', "got `str`"),
        ("fk", '{"q": [1, 2, 3, 4, 5, true]}', "got `bool`"),
        ("jacobian", '{"q": [0, 0, 0, 0, 0, 0], "p": 1}', "unknown field `p`"),
        ("jacobian", "{}", "missing required field `q`"),
        ("ik", '{"T6": [[1, 0, 0, 0.3], [0, 1, 0, 0]]}', "length 3"),
        ("ik", '{"T6": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}', "length 4"),
        ("ik", '{"T6": [[1, 0, 0, 0.3], [0, 1, 0, 0], [0, 0, -1, 0.1]]}', "not rigid"),
        ("ik", '{"T6": [[2, 0, 0, 0.3], [0, 1, 0, 0], [0, 0, 1, 0.1]]}', "1e-06 at most"),
        ("ik", '{"T6": [[1, 0, 0, 9.0], [0, 1, 0, 0], [0, 0, 1, 0.1]]}', "too_far"),
        ("ik", '{"T6": [[1, 0, 0, 0.0], [0, 1, 0, 0], [0, 0, 1, 0.1]]}', "shoulder_cylinder"),
        ("ik", json.dumps({"T6": POSE, "config": "left up"}), "left|right, up|down, flip|noflip"),
        ("ik", json.dumps({"T6": POSE, "config": None}), "got `null`"),
        ("ik", json.dumps({"T6": FOLDED, "config": "left up noflip"}), "joint 5 "),
    ],
)
def test_a_bad_line_gives_an_error_line(verb: str, line: str | bytes, says: str) -> None:
    reply = answer(verb, PUMA_260, line)
    assert "\n" not in reply
    assert json.loads(reply).keys() == {"error"}
    assert says in json.loads(reply)["error"]


def run(arguments: list[str], lines: str | bytes) -> tuple[int, list[dict[str, object]]]:
    app = typer.Typer()
    app.command("kin")(kin)
    result = CliRunner().invoke(app, arguments, input=lines)
    return result.exit_code, [json.loads(line) for line in result.stdout.splitlines()]


def test_the_stream_goes_on_after_a_bad_line() -> None:
    good = json.dumps({"q": Q}).encode()
    stream = b"\n".join([good, b"", b"{bad", b"\xff", b"   ", good + b"\r", good])
    code, replies = run(["fk", "--arm", "puma260"], stream)
    assert code == 0
    assert [[*reply] for reply in replies] == [["T6"], ["error"], ["error"], ["T6"], ["T6"]]
    assert replies[0] == replies[-1] == {"T6": POSE}


def test_the_arm_is_the_one_named() -> None:
    line = json.dumps({"q": Q})
    code, replies = run(["fk", "--arm", "puma560"], line)
    assert (code, replies) == (0, [{"T6": direct(PUMA_560, Q).rows()}])
    assert run(["fk", "--arm", "puma762"], line)[0] != 0
    assert run(["fly"], line)[0] != 0
    assert run(["fk"], "") == (0, [])


def test_full_precision_survives_the_line() -> None:
    q = [math.pi / 7] * 6
    reply = json.loads(answer("fk", PUMA_260, json.dumps({"q": q})))
    assert Transform.from_rows(reply["T6"]) == direct(PUMA_260, q)
