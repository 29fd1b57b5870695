"""All mutants that the operators make of the joint's code, and a sample of them."""

import ast
import hashlib
import random
from collections.abc import Iterator, Mapping, Set
from functools import cache
from typing import Final

from node_mutants.mutant import Mutant, source_of
from node_mutants.operators import OPERATORS, Operator

SEED: Final = 1986
SAMPLE: Final = 300

_FOLDERS: Final = {
    "joint_nodes": (
        *("angle_solver", "compliance", "controller", "field_node", "friction", "homing", "inputs"),
        *("joint", "ladder", "motion_watch", "sensing", "servo", "state_actions", "states"),
        "stop_ramp",
    ),
    "joint_nodes/detectors": (
        *("bus", "drive", "following", "plausible_rows", "runaway", "sensors", "setpoint_step"),
    ),
    "node": ("encoder_reference", "endpoint", "protocol"),
    "setpoint": ("blend", "cartesian", "frames", "history", "joint", "succession"),
    "wire": ("protection", "configuration"),
    "kinematics": ("joint_solver", "closed_form", "limits"),
}
FILES: Final = tuple(f"{folder}/{name}.py" for folder, names in _FOLDERS.items() for name in names)
"""The joint's code: files under ``rfms_can/``. The gripper's is not in it, nor the codec, which is
generated from the DBC, and tables that are the wire contract itself."""

NOT_OF_A_JOINT: Final = {
    "joint_nodes/detectors/bus.py": {"PortWatch"},
    "joint_nodes/field_node.py": {"_watch_port"},
    "joint_nodes/controller.py": {"record_terms"},
    "joint_nodes/joint.py": {"record_terms", "theta", "speed", "torque"},
    "joint_nodes/servo.py": {"ServoTerms"},
    "joint_nodes/state_actions.py": {"by_case", "sends"},
    "node/endpoint.py": {"bad_frames", "lost"},
    "node/protocol.py": {"hears_itself"},
    "setpoint/blend.py": {
        *("blend_parameter", "stop_parameter", "segment_derivatives"),
        *("thesis", "coefficients", "derivatives"),
    },
    "setpoint/frames.py": {
        *("values_of", "as_received", "angles_as_received", "_elements", "_received"),
    },
    "setpoint/joint.py": {"step", "bend", "mark", "return_to"},
    "wire/configuration.py": {
        *("plant_hash", "geometry_values", "_whole_micrometres", "_whole_angle"),
    },
    "kinematics/joint_solver.py": {"refusal"},
    "kinematics/limits.py": {"within_limits"},
}
"""Functions and classes of these files that no joint node calls on the bus: the master's half of
what it shares with the joints, recordings, what tests and reports ask, and what a joint asks its
CAN controller, which no tester on the bus has in its hand."""

_NO_CODE: Final = ("__slots__", "gripper", "GRIPPER_PARAMETERS")
"""Names to which nothing is assigned that a joint computes with."""


@cache
def population() -> tuple[Mutant, ...]:
    """Every mutant, file by file, in the order of the text."""
    return tuple(mutant for file in FILES for mutant in mutants_of(file))


def sample(seed: int = SEED, size: int = SAMPLE) -> list[Mutant]:
    """Mutants drawn without replacement, each as likely as any other."""
    return random.Random(seed).sample(population(), size)


def fingerprint() -> str:
    """Of the code that the mutants are made of: samples of other code are other ones."""
    text = "".join(source_of(file) for file in FILES)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def mutants_of(
    file: str, left_out: Set[str] | None = None, operators: Mapping[str, Operator] = OPERATORS
) -> Iterator[Mutant]:
    """The mutants of one file.

    Args:
        file: under ``rfms_can/``.
        left_out: functions and classes that have none; without it those of ``NOT_OF_A_JOINT``.
        operators: that make them, by name.
    """
    if left_out is None:
        left_out = NOT_OF_A_JOINT.get(file, set())
    source = source_of(file)
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def place(line: int, column: int) -> int:
        text = source[starts[line - 1] : starts[line]]
        return starts[line - 1] + len(text.encode()[:column].decode())

    made: set[tuple[int, str, str]] = set()
    for node in _code(ast.parse(source), left_out):
        for kind, operator in operators.items():
            for at, after in operator(node):
                assert isinstance(at, ast.expr | ast.stmt)
                assert at.end_lineno is not None and at.end_col_offset is not None
                begin = place(at.lineno, at.col_offset)
                before = source[begin : place(at.end_lineno, at.end_col_offset)]
                if (begin, before, after) in made:
                    continue
                made.add((begin, before, after))
                name = f"{file}:{at.lineno}:{at.col_offset} {kind} {after}"
                yield Mutant(name, file, at.lineno, kind, before, _fitted(at, after), begin)


def _fitted(at: ast.expr | ast.stmt, after: str) -> str:
    """Instead of an expression it keeps together, whatever stands around it."""
    return f"({after})" if isinstance(at, ast.expr) else after


def _code(node: ast.AST, left_out: Set[str]) -> Iterator[ast.AST]:
    """What a node computes with: no annotations, no messages of errors, no ``__slots__``."""
    yield node
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list", "type_params", "bases"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not _is_left_out(child, left_out):
                yield from _code(child, left_out)


def _is_left_out(node: ast.AST, names: Set[str]) -> bool:
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return node.name in names
    if isinstance(node, ast.Assign | ast.AnnAssign):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        return any(ast.unparse(target) in _NO_CODE for target in targets)
    if isinstance(node, ast.keyword):
        return node.arg == "gripper"
    if isinstance(node, ast.If):
        return ast.unparse(node.test) == "self.recording"
    return isinstance(node, ast.JoinedStr | ast.Raise | ast.Assert | ast.Import | ast.ImportFrom)
