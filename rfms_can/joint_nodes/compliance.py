"""The row a joint works with: received with its set, active at the SYNC that names the set.

Row n of C_theta turns the six joint errors into the real error of joint n (Eq. 5.10); under the
inertia-weighted law row n of M C_theta makes its torque of them. The master names a set only when
all six frames of it have gone out, and CAN delivers a frame to everyone or to no one: so either all
nodes swap or none does, and each needs to hear its own row alone. A set that has not arrived never
acts.
"""

from typing import Final

from rfms_can.wire.contract import NO_SET
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Rows
from rfms_can.wire.vocabulary import Law

_UNIT_ROWS: Final = tuple(tuple(float(i == j) for j in JOINTS) for i in JOINTS)
_NO_ROW: Final = (0.0,) * len(JOINTS)


class RowSets:
    """The active row of one joint, and the one that is arriving.

    Attributes:
        first: row of C_theta, 6 floats; under the weighted law of M, kg m2.
        second: row of M, kg m2, 6 floats; under the weighted law of M C_theta.
        gravity: holding torque, Nm.
        law: ``Law`` of the active set.
        damping: mu of the compliant directions, 1/s.
        selection: bits of the directions that comply; 0 while the arm is rigid.
        specification: counts the changes of what complies.
        number: set number, ``NO_SET`` before the first swap.
    """

    __slots__ = (
        "_arrived",
        "_joint",
        "damping",
        "first",
        "gravity",
        "law",
        "number",
        "second",
        "selection",
        "specification",
    )

    def __init__(self, joint: int) -> None:
        self._joint = joint
        self.clear()

    def clear(self) -> None:
        """Forget all rows: identity compliance, no inertia, no gravity."""
        self.first: tuple[float, ...] = _UNIT_ROWS[self._joint - 1]
        self.second: tuple[float, ...] = _NO_ROW
        self.gravity = 0.0
        self.law: int = Law.PID
        self.damping = 0.0
        self.selection = 0
        self.specification = 0
        self.number = NO_SET
        self._arrived: Rows | None = None

    def hear(self, rows: Rows) -> None:
        """This joint's row of a set came in."""
        self._arrived = rows

    def swap(self, number: int) -> bool:
        """SYNC names set ``number``: use its row if it is here, keep the old one if not.

        Returns:
            Whether the named set is active now.
        """
        if number == self.number:
            return True
        rows = self._arrived
        if rows is None or rows.set != number:
            return False
        self.first = rows[0:6]
        self.second = rows[6:12]
        self.gravity = rows.gravity
        self.law = rows.law
        self.damping = rows.damping
        self.selection = rows.selection
        self.specification = rows.specification
        self.number = number
        return True

    @property
    def inertia(self) -> float:
        """The joint's own element of M, kg m2."""
        return (self.first if self.law == Law.WEIGHTED else self.second)[self._joint - 1]
