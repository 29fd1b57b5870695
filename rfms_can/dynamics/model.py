"""The model that a master compensates with: one protocol, four implementations."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final, Protocol

import numpy as np

from rfms_can.arm import JOINT_COUNT, Arm, Load, load_alone
from rfms_can.arm.calibration import Calibration
from rfms_can.arm.load import NOTHING
from rfms_can.dynamics.fitted import fitted_constants
from rfms_can.dynamics.rigid_body import ArmDynamics, Matrix
from rfms_can.dynamics.simplified import SimplifiedDynamics
from rfms_can.errors import ArmError
from rfms_can.kinematics import jacobian


class DynamicsModel(Protocol):
    """Inertia, gravity and Jacobian at the angles of the last update; see ``ArmDynamics``."""

    @property
    def J(self) -> Matrix:
        """Jacobian in the T6 frame (6, 6)."""

    @property
    def M(self) -> Matrix:
        """Joint-space inertia, kg m2 (6, 6)."""

    @property
    def g(self) -> Matrix:
        """Torque that holds the arm, Nm (6)."""

    def update(self, q: Sequence[float]) -> None:
        """Compute them at joint angles ``q`` (6, rad)."""


class NoDynamics:
    """No compensation: inertia and gravity are zero."""

    def __init__(self, arm: Arm) -> None:
        self.arm = arm
        self.M: Matrix = np.zeros((JOINT_COUNT, JOINT_COUNT))
        self.g: Matrix = np.zeros(JOINT_COUNT)
        self._q: tuple[float, ...] = arm.park

    def update(self, q: Sequence[float]) -> None:
        """Store the angles for the Jacobian."""
        self._q = tuple(q)

    @property
    def J(self) -> Matrix:
        """Jacobian in the T6 frame (6, 6)."""
        return np.array(jacobian(self.arm, self._q))


class LoadedDynamics:
    """A model of the arm plus its load (thesis IV.6).

    Attributes:
        J: Jacobian in the T6 frame (6, 6).
        M: inertia of both, kg m2 (6, 6).
        g: torque that holds both, Nm (6).
        load: in the hand.
    """

    def __init__(self, arm: Arm, model: DynamicsModel) -> None:
        self.arm = arm
        self._model = model
        self.load = NOTHING
        self._alone: ArmDynamics | None = None
        self.M, self.g = model.M, model.g

    def carry(self, load: Load) -> None:
        """Set the load in the hand; a mass of 0 removes it."""
        if load != self.load:
            self.load = load
            self._alone = ArmDynamics(load_alone(self.arm, load)) if load.mass else None

    def update(self, q: Sequence[float]) -> None:
        """Compute at joint angles ``q`` (6, rad)."""
        model, alone = self._model, self._alone
        model.update(q)
        self.M, self.g = model.M, model.g
        if alone is not None:
            alone.update(q)
            self.M, self.g = self.M + alone.M, self.g + alone.g

    @property
    def J(self) -> Matrix:
        """Jacobian in the T6 frame (6, 6)."""
        return self._model.J


def _full(arm: Arm, calibration: Calibration | None) -> DynamicsModel:
    if calibration is None:
        return ArmDynamics(arm)
    return ArmDynamics(arm, np.array(calibration.parameters), calibration.armature)


def _simplified(arm: Arm, calibration: Calibration | None) -> DynamicsModel:
    given = fitted_constants(ArmDynamics(arm)) if calibration is None else calibration.constants
    return SimplifiedDynamics(arm, given)


def _none(arm: Arm, calibration: Calibration | None) -> DynamicsModel:
    return NoDynamics(arm)


FULL: Final = "full"
SIMPLIFIED: Final = "simplified"
NONE: Final = "none"
_MODELS: Final[Mapping[str, Callable[[Arm, Calibration | None], DynamicsModel]]] = {
    FULL: _full,
    SIMPLIFIED: _simplified,
    NONE: _none,
}
KINDS: Final = tuple(_MODELS)


def check_kind(kind: str) -> None:
    """Refuse a model that does not exist.

    Raises:
        ArmError: the message lists those that exist.
    """
    if kind not in KINDS:
        raise ArmError(f"no dynamics {kind!r}; there are: {', '.join(KINDS)}")


def make_dynamics(arm: Arm, kind: str, calibration: Calibration | None = None) -> LoadedDynamics:
    """A model by its name, with the identified parameters of a calibration, if given.

    Raises:
        ArmError: the model does not exist, or the calibration is another arm's.
    """
    check_kind(kind)
    if calibration is not None:
        calibration.check(arm)
    return LoadedDynamics(arm, _MODELS[kind](arm, calibration))
