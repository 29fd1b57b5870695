"""A second copy of the joint's code in this process, with one file of it changed.

The tester, or the other nodes of a run, keep the code as it is: what a mutant changes in the rule
of counters or in a CRC must not change on both sides.
"""

import importlib
import importlib.abc
import importlib.util
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.machinery import ModuleSpec, SourceFileLoader
from types import CodeType, ModuleType
from typing import Any, Final

from node_mutants.mutant import PACKAGE, Mutant
from rfms_can.node.protocol import Node

OWN: Final = (
    *("rfms_can.joint_nodes", "rfms_can.setpoint", "rfms_can.node", "rfms_can.kinematics"),
    *("rfms_can.wire.protection", "rfms_can.wire.configuration", "rfms_can.wire.contract"),
)
"""Modules of which a mutant has a copy of its own; all else is shared."""

MakeJoint = Callable[[int, int], Node]
"""Makes a node of a joint and a boot id."""


class _Loader(SourceFileLoader):
    def __init__(self, mutant: Mutant) -> None:
        super().__init__(mutant.module, str(PACKAGE / mutant.file))
        self._mutant = mutant

    def get_code(self, fullname: str) -> CodeType | None:
        return compile(self._mutant.source, self.path, "exec")


class Finder(importlib.abc.MetaPathFinder):
    """Loads a mutant where its module is imported."""

    def __init__(self, mutant: Mutant) -> None:
        self._mutant = mutant

    def find_spec(
        self, fullname: str, _path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The mutant, if the module is its own."""
        if fullname != self._mutant.module:
            return None
        return importlib.util.spec_from_loader(fullname, _Loader(self._mutant))


def _is_own(name: str) -> bool:
    return any(name == own or name.startswith(own + ".") for own in OWN)


@contextmanager
def _apart() -> Iterator[None]:
    """What is imported meanwhile, of the modules ``OWN``, is forgotten afterwards."""
    before = {name: module for name, module in sys.modules.items() if _is_own(name)}
    for name in before:
        del sys.modules[name]
    try:
        yield
    finally:
        for name in [name for name in sys.modules if _is_own(name)]:
            del sys.modules[name]
        sys.modules.update(before)
        for name, module in before.items():
            parent, _, own = name.rpartition(".")
            setattr(sys.modules[parent], own, module)


def joint_of(mutant: Mutant | None) -> MakeJoint:
    """The joint node of a mutant; of the code as it is, loaded in the same way, if there is none.

    Raises:
        Exception: whatever the mutant raises where it is imported.
    """
    finder = None if mutant is None else Finder(mutant)
    with _apart():
        if finder is not None:
            sys.meta_path.insert(0, finder)
        try:
            node: Any = importlib.import_module("rfms_can.joint_nodes.joint").JointNode
            wire = importlib.import_module("rfms_can.wire.contract").Wire()
        finally:
            if finder is not None:
                sys.meta_path.remove(finder)
    return lambda joint, boot_id: node(joint, wire, boot_id)
