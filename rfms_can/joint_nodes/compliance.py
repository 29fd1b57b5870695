"""The rows a node works with: received as a set, active together, at one SYNC (PROTOCOL 1).

Row n of C_theta turns the six joint errors into the real error of joint n (Eq. 5.10); row n of
M C_theta weights accelerations. A set counts only when all six rows of it were heard: CAN either
delivers a frame to everyone or to no one, so either all nodes swap or none does.
"""

from typing import Final

from rfms_can.wire import JOINTS
from rfms_can.wire.records import Rows

_WHOLE: Final = (1 << len(JOINTS)) - 1
_UNIT_ROWS: Final = tuple(tuple(float(i == j) for j in JOINTS) for i in JOINTS)


class RowSets:
    """The active row of one joint, and the one that is arriving.

    Attributes:
        compliance: row of C_theta, 6 floats.
        weighted: row of M C_theta, kg m2, 6 floats.
        gravity: holding torque, Nm.
        law: ``Law`` of the active set.
        number: set number, None before the first swap.
    """

    __slots__ = (
        "_arrived",
        "_joint",
        "_own",
        "_set",
        "compliance",
        "gravity",
        "law",
        "number",
        "weighted",
    )

    def __init__(self, joint: int) -> None:
        self._joint = joint
        self.clear()

    def clear(self) -> None:
        """Forget all rows: identity compliance, no inertia, no gravity."""
        self.compliance: tuple[float, ...] = _UNIT_ROWS[self._joint - 1]
        self.weighted: tuple[float, ...] = (0.0,) * len(JOINTS)
        self.gravity = 0.0
        self.law = 0
        self.number: int | None = None
        self._set: int | None = None
        self._arrived = 0
        self._own: Rows | None = None

    def hear(self, joint: int, rows: Rows) -> None:
        """Row ``joint`` of a set came in."""
        if rows.set != self._set:
            self._set = rows.set
            self._arrived = 0
        self._arrived |= 1 << (joint - 1)
        if joint == self._joint:
            self._own = rows

    def swap(self, number: int) -> bool:
        """SYNC names set ``number``: use it if it is whole, keep the old one if not.

        Returns:
            Whether the named set is active now.
        """
        if number == self.number:
            return True
        rows = self._own
        if number != self._set or self._arrived != _WHOLE or rows is None:
            return False
        self.compliance = rows[0:6]
        self.weighted = rows[6:12]
        self.gravity = rows.gravity
        self.law = rows.law
        self.number = number
        return True
