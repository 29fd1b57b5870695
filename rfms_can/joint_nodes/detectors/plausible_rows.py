"""Rows that cannot be: a joint knows its own torque and, to a factor, its own inertia."""

from collections.abc import Mapping
from typing import Final

from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.detectors.following import Excess
from rfms_can.wire.contract import NO_SET
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Rows
from rfms_can.wire.vocabulary import Law, Parameter

GRAVITY_STEP: Final = 0.25
"""Change of gravity from one set to the next, over the torque limit: a load that is taken up."""
INERTIA_FACTOR: Final = 10.0
"""Own inertia over that for which the gains were made: of a PUMA's joints it goes from 0.3 to 3."""
AGREEMENT: Final = 1e-3
"""By which the row of a rigid law may be off: of 1, or of the own inertia."""


class RowsWatch:
    """Judges the rows of one joint before they act.

    Args:
        parameters: the node's configuration.
        joint: its number, 1 to 6.
    """

    __slots__ = ("_gravity_step", "_index", "_inertia", "_torque", "_unit")

    def __init__(self, parameters: Mapping[Parameter, float], joint: int) -> None:
        p = parameters
        self._index: Final = joint - 1
        self._torque: Final = p[Parameter.TORQUE_LIMIT]
        self._gravity_step: Final = GRAVITY_STEP * self._torque
        natural = p[Parameter.NATURAL_FREQUENCY]
        self._inertia: Final = INERTIA_FACTOR * p[Parameter.KP] / natural**2 if natural else 0.0
        self._unit: Final = tuple(float(other == joint) for other in JOINTS)

    def excess(self, rows: Rows, active: RowSets) -> Excess | None:
        """What cannot be of rows that are to act after the active ones; None if all can."""
        gravity, inertia = rows.gravity, rows[6:12]
        own = inertia[self._index]
        if abs(gravity) > self._torque:
            return Excess(gravity, self._torque)
        if active.number != NO_SET and abs(gravity - active.gravity) > self._gravity_step:
            return Excess(gravity - active.gravity, self._gravity_step)
        if own < 0.0 or own > self._inertia > 0.0:
            return Excess(own, self._inertia)
        if rows.selection:
            return None
        due = self._unit if rows.law == Law.PID else inertia
        margin = AGREEMENT * (1.0 if rows.law == Law.PID else own)
        return _farthest_off(rows[0:6], due, margin)


def _farthest_off(row: tuple[float, ...], due: tuple[float, ...], margin: float) -> Excess | None:
    """The element that is farthest from what it should be, and that; None if all are close."""
    off = [abs(value - wanted) for value, wanted in zip(row, due, strict=True)]
    farthest = off.index(max(off))
    if off[farthest] <= margin:
        return None
    return Excess(row[farthest], due[farthest])
