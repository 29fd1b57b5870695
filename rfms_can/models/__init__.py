"""Models of an arm's dynamics a master can compensate with: the full one and simpler ones."""

from rfms_can.models.dynamics_model import DynamicsModel, LoadedDynamics, make_dynamics
from rfms_can.models.fitted import fitted_constants
from rfms_can.models.simplified import SimplifiedDynamics

__all__ = [
    "DynamicsModel",
    "LoadedDynamics",
    "SimplifiedDynamics",
    "fitted_constants",
    "make_dynamics",
]
