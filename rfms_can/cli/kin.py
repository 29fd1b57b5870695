"""``rfms kin``: direct and inverse kinematics and the Jacobian, JSON lines in, JSON lines out.

::

    fk        {"q": [6]}                                        -> {"T6": [[3x4]]}
    jacobian  {"q": [6]}                                        -> {"J": [[6x6]]}
    ik        {"T6": [[3x4]], "config": "left up noflip"}       -> {"q": [6]}

Metres and radians at full double precision; J has columns d/d theta_1..6 and rows vx vy vz wx wy
wz, in the T6 frame. Each line is answered on its own: an invalid line gives ``{"error": "..."}``
and the next one is read. Empty lines are skipped.
"""

from collections.abc import Callable
from enum import StrEnum
from typing import Annotated, Final

import msgspec
import typer

from rfms_can.arm import Arm, arm_by_name
from rfms_can.cli.options import ARM_WORDS
from rfms_can.errors import KinematicsError
from rfms_can.kinematics import Configuration, InverseKinematics, direct, jacobian
from rfms_can.transform import RIGID_TOLERANCE, Transform

DEFAULT_CONFIGURATION: Final = "left up noflip"
"""Default configuration of ``ik``: code 0 of the wire."""

_Number = Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]
"""Wider than any arm or joint, and small enough for sines and squares to mean something."""

_Angles = tuple[_Number, _Number, _Number, _Number, _Number, _Number]
_Row = tuple[_Number, _Number, _Number, _Number]


_SHAPES: Final = {
    "fk": '{"q": [6 radians]}',
    "jacobian": '{"q": [6 radians]}',
    "ik": '{"T6": [[3 rows of 4]], "config": "left|right up|down flip|noflip"}',
}


class Verb(StrEnum):
    """Computation applied to each line."""

    FK = "fk"
    IK = "ik"
    JACOBIAN = "jacobian"


class _JointLine(msgspec.Struct, forbid_unknown_fields=True):
    """A line of ``fk`` and ``jacobian``: radians."""

    q: _Angles


class _PoseLine(msgspec.Struct, forbid_unknown_fields=True):
    """A line of ``ik``: the first three rows of T6, metres."""

    T6: tuple[_Row, _Row, _Row]
    config: str = DEFAULT_CONFIGURATION


_decode_joints: Final = msgspec.json.Decoder(_JointLine).decode
_decode_pose: Final = msgspec.json.Decoder(_PoseLine).decode


def kin(
    verb: Annotated[Verb, typer.Argument(help="fk: q to T6; ik: T6 to q; jacobian: q to J.")],
    arm: Annotated[str, typer.Option(help=ARM_WORDS)] = "puma260",
) -> None:
    """Answer kinematics questions, one JSON line in, one JSON line out.

    fk and jacobian read {"q": [6 rad]}; ik reads {"T6": [[3x4]], "config": "left up noflip"}
    ("config" may be left out, this is its default). A line that cannot be answered gives
    {"error": "..."}; the exit code is 0 when the input has ended.
    """
    answer = answerer(verb, arm_by_name(arm))
    lines, answers = typer.get_binary_stream("stdin"), typer.get_text_stream("stdout")
    for line in lines:
        if line.strip():
            answers.write(answer(line) + "\n")
            answers.flush()


def answer(verb: str, arm: Arm, line: str | bytes) -> str:
    """The JSON answer to one line; never raises on what the line holds."""
    return answerer(verb, arm)(line)


def answerer(verb: str, arm: Arm) -> Callable[[str | bytes], str]:
    """``answer`` for many lines: the arm's constants are computed once."""
    solver = InverseKinematics(arm)
    replies: dict[str, Callable[[str | bytes], dict[str, object]]] = {
        Verb.FK: lambda line: {"T6": direct(arm, _decode_joints(line).q).rows()},
        Verb.JACOBIAN: lambda line: {"J": jacobian(arm, _decode_joints(line).q)},
        Verb.IK: lambda line: _inverse(solver, _decode_pose(line)),
    }
    reply = replies[verb]

    def answer_line(line: str | bytes) -> str:
        try:
            return msgspec.json.encode(reply(line)).decode()
        except msgspec.MsgspecError as error:
            return _error(f"{error}; {verb} takes {_SHAPES[verb]}")
        except KinematicsError as error:
            return _error(str(error))

    return answer_line


def _inverse(solver: InverseKinematics, pose: _PoseLine) -> dict[str, object]:
    configuration = Configuration.parse(pose.config)
    t6 = Transform.from_rows(pose.T6)
    off = t6.rigidity_error()
    if not off <= RIGID_TOLERANCE:
        raise KinematicsError(
            f"T6 is not rigid: n, o, a deviate by {off:.3g} from a right-handed orthonormal set, "
            f"{RIGID_TOLERANCE:g} at most: give them with seven digits or more"
        )
    reply: dict[str, object] = {"q": solver.solve(t6, configuration)}
    singularity = solver.wrist_singularity(t6, configuration)
    if singularity is not None:
        reply["warning"] = str(singularity)
    return reply


def _error(text: str) -> str:
    return msgspec.json.encode({"error": text}).decode()
