"""The operators of a joint's mutants, and two for tables: what guards an arm is mostly tables."""

import ast
from enum import Enum
from typing import Final

from node_mutants import operators
from node_mutants.operators import Change, Changes, Operator

from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.joint_nodes.state_actions import TorqueSource
from rfms_can.joint_nodes.states import Event
from rfms_can.wire.protection import Refusal
from rfms_can.wire.vocabulary import Command, ConfigStatus, FaultCode, NodeState, Parameter

_ENUMERATIONS: Final[tuple[type[Enum], ...]] = (
    *(Command, ConfigStatus, Event, FaultCode, NodeState, Parameter, Reaction, Refusal),
    TorqueSource,
)
_BY_NAME: Final[dict[str, type[Enum]]] = {
    **{each.__name__: each for each in _ENUMERATIONS},
    **{"S": NodeState, "R": Reaction, "T": TorqueSource},
}
"""Also by the letters that ``state_actions.py`` has for them."""


def entry(node: ast.AST) -> Changes:
    """An entry of a table is not found under its key."""
    if isinstance(node, ast.Dict):
        for key in node.keys:
            if key is not None:
                yield Change(key, f"'not', {ast.unparse(key)}")


def member(node: ast.AST) -> Changes:
    """The member of an enumeration that comes after the one that is meant."""
    if not (isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)):
        return
    enumeration = _BY_NAME.get(node.value.id)
    names = [] if enumeration is None else list(enumeration.__members__)
    if node.attr in names:
        following = names[(names.index(node.attr) + 1) % len(names)]
        yield Change(node, f"{node.value.id}.{following}")


OPERATORS: Final[dict[str, Operator]] = {
    **operators.OPERATORS,
    "entry": entry,
    "member": member,
}
