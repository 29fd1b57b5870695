"""The math processor: row sets of each cycle, from a model of the arm (VI.4.5)."""

from collections.abc import Sequence
from typing import Final

from rfms_can.arm import Arm
from rfms_can.models import make_dynamics
from rfms_can.models.dynamics_model import FULL
from rfms_can.wire import JOINTS, LAST_SET, NO_SET
from rfms_can.wire.vocabulary import Law

RowValues = tuple[float, ...]
"""Values of one ROWS frame: C_theta row (6), M C_theta row (6), gravity, set, law."""

_IDENTITY: Final = tuple(tuple(float(i == j) for j in JOINTS) for i in JOINTS)


class MathProcessor:
    """Computes the rows of C_theta and M C_theta, and gravity, at measured joint angles.

    Attributes:
        dynamics: the model; the full one of the arm's published numbers unless another is put in.
        compliance: C_theta, 6 rows of 6; the identity while nothing complies.
        law: ``Law`` the nodes shall use.
    """

    def __init__(self, arm: Arm) -> None:
        self.dynamics = make_dynamics(arm, FULL)
        self._set = NO_SET
        self.compliance: tuple[tuple[float, ...], ...] = _IDENTITY
        self.law = Law.PID

    def rows(self, q: Sequence[float]) -> tuple[int, list[RowValues]]:
        """The next set at joint angles ``q`` (6, rad): its number and the values of its frames."""
        dynamics = self.dynamics
        dynamics.update(q)
        number = self._set = self._set % LAST_SET + 1
        compliance, law = self.compliance, self.law
        inertia = dynamics.M
        weighted = (inertia if compliance is _IDENTITY else inertia @ compliance).tolist()
        gravity = dynamics.g.tolist()
        return number, [
            (*compliance[i], *weighted[i], gravity[i], number, law) for i in range(len(JOINTS))
        ]
