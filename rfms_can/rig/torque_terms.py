"""What each joint's torque was made of, cycle by cycle: recorded on the simulated bus.

``terms.npz`` holds ``terms``, the names of the columns after the first, and ``joint_1`` to
``joint_6``: a row for each torque, its cycle since enable and then its terms, Nm.
"""

from array import array
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from rfms_can.joint_nodes.joint import JointNode
from rfms_can.joint_nodes.servo import ServoTerms

TERMS: Final = "terms.npz"
NAMES: Final = "terms"
"""Key of the names of the columns."""
_WIDTH: Final = 1 + len(ServoTerms._fields)


def joint_key(joint: int) -> str:
    """Key of the rows of joint 1 to 6."""
    return f"joint_{joint}"


class TermsRecorder:
    """Keeps the terms of every torque of some joints of this process.

    Args:
        joints: the nodes; from now on they make terms.
    """

    def __init__(self, joints: Sequence[JointNode]) -> None:
        self._values = {node.number: array("d") for node in joints}
        for node in joints:
            node.record_terms(partial(_keep, self._values[node.number]))

    def begin(self) -> None:
        """Forget what was recorded so far, as when the arm is enabled and cycles begin at 0."""
        for values in self._values.values():
            del values[:]

    def rows(self, joint: int) -> npt.NDArray[np.float64]:
        """A row for each torque of joint 1 to 6: cycle, then the terms, Nm (N, 12)."""
        return np.array(self._values[joint], dtype=np.float64).reshape(-1, _WIDTH)

    def save(self, path: Path) -> None:
        """Write ``terms.npz``.

        Raises:
            OSError: it cannot be written.
        """
        with path.open("wb") as file:
            np.savez_compressed(
                file,
                allow_pickle=False,
                **{NAMES: np.array(ServoTerms._fields)},
                **{joint_key(joint): self.rows(joint) for joint in self._values},
            )


def _keep(values: "array[float]", cycle: int, terms: ServoTerms) -> None:
    values.append(cycle)
    values.extend(terms)
