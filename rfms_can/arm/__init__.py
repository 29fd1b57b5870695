"""The available arms by name, and their data types.

Numbers with their sources: ``puma.py``. Their meaning: ``mechanism.py``, ``components.py`` and
``board_scale.py``.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from rfms_can.arm.board_scale import BoardScale
from rfms_can.arm.components import Correction, Drive, JointFriction, Link
from rfms_can.arm.load import Load, known_load, load_alone
from rfms_can.arm.mechanism import JOINT_COUNT, Arm, Gripper
from rfms_can.arm.puma import PUMA_260, PUMA_560
from rfms_can.errors import ArmError

__all__ = [
    "ARMS",
    "FRICTION_SETS",
    "JOINT_COUNT",
    "PUMA_260",
    "PUMA_560",
    "Arm",
    "BoardScale",
    "Correction",
    "Drive",
    "Gripper",
    "JointFriction",
    "Link",
    "Load",
    "arm_by_name",
    "friction_set",
    "known_load",
    "load_alone",
]

ARMS: Final[Mapping[str, Arm]] = MappingProxyType({arm.name: arm for arm in (PUMA_260, PUMA_560)})
"""All arms there are, by name: an arm that is not in it does not exist for any program."""

FRICTION_SETS: Final = tuple(
    dict.fromkeys(name for arm in ARMS.values() for name in arm.friction_sets)
)
"""Names of the friction sets of all arms."""


def arm_by_name(name: str) -> Arm:
    """The arm called ``name``.

    Raises:
        ArmError: the arm does not exist; the message lists those that do.
    """
    arm = ARMS.get(name)
    if arm is None:
        raise ArmError(f"no arm {name!r}; there are: {', '.join(ARMS)}")
    return arm


def friction_set(arm: Arm, name: str) -> tuple[JointFriction, ...]:
    """The friction of the arm's six joints in the set called ``name``.

    Raises:
        ArmError: the set does not exist; the message lists those that do.
    """
    joints = arm.friction_sets.get(name)
    if joints is None:
        sets = ", ".join(arm.friction_sets)
        raise ArmError(f"{arm.name} has no friction set {name!r}; there are: {sets}")
    return joints
