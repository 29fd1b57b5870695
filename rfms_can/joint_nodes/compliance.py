"""The rows a joint works with: received with their set, active at the SYNC that names the set.

Row n of C_theta turns the six joint errors into the real error of joint n (Eq. 5.10); under the
inertia-weighted law, row n of M C_theta makes its torque of them. The master names a set only after
all six frames of it have gone out, and CAN delivers a frame to all nodes or to none: so either all
nodes change over or none does, and each needs to receive its own rows alone. A set that has not
arrived never acts.
"""

from typing import Final

from rfms_can.wire.contract import NO_SET
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Rows
from rfms_can.wire.vocabulary import Law

_UNIT_ROWS: Final = tuple(tuple(float(i == j) for j in JOINTS) for i in JOINTS)
_ZERO_ROW: Final = (0.0,) * len(JOINTS)


class RowSets:
    """The active rows of one joint, and the set that is arriving.

    Attributes:
        law_row: what the law multiplies the errors by, 6 floats: row of C_theta; of M C_theta
            (kg m2) under the weighted law.
        inertia_row: what multiplies the desired accelerations: row of M, kg m2, 6 floats.
        gravity: holding torque, Nm.
        law: ``Law`` of the active set.
        damping: mu of the compliant directions, 1/s.
        selection: bits of the directions that comply; 0 while the arm is rigid.
        specification: counts the changes of what complies.
        number: set number, ``NO_SET`` before the first set acts.
    """

    __slots__ = (
        "_arrived",
        "_index",
        "damping",
        "gravity",
        "inertia_row",
        "law",
        "law_row",
        "number",
        "selection",
        "specification",
    )

    def __init__(self, joint: int) -> None:
        self._index = joint - 1
        self.clear()

    def clear(self) -> None:
        """Forget all rows: identity compliance, no inertia, no gravity."""
        self.law_row: tuple[float, ...] = _UNIT_ROWS[self._index]
        self.inertia_row: tuple[float, ...] = _ZERO_ROW
        self.gravity = 0.0
        self.law: int = Law.PID
        self.damping = 0.0
        self.selection = 0
        self.specification = 0
        self.number = NO_SET
        self._arrived: Rows | None = None

    def receive(self, rows: Rows) -> None:
        """Keep this joint's rows of a set until SYNC names it."""
        self._arrived = rows

    def waiting(self, number: int) -> Rows | None:
        """The rows of set ``number``, if they are here and do not act yet."""
        rows = self._arrived
        return rows if rows is not None and rows.set == number else None

    def activate(self, rows: Rows) -> None:
        """Use these rows from now on."""
        self.law_row, self.inertia_row = rows[0:6], rows[6:12]
        self.gravity = rows.gravity
        self.law = rows.law
        self.damping = rows.damping
        self.selection = rows.selection
        self.specification = rows.specification
        self.number = rows.set

    @property
    def own_inertia(self) -> float:
        """The joint's own element of M, kg m2."""
        return self.inertia_row[self._index]
