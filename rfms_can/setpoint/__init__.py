"""Set-points: the Cartesian one, once a cycle on the bus, and the joints', computed by the nodes.

``cartesian.py`` has the master's set-point, ``frames.py`` its two frames, ``succession.py`` the
valid order of states, ``joint.py`` the joint's set-point, with the polynomials of ``blend.py`` and
the derivatives of ``history.py``.
"""

from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.setpoint.joint import JointSetpoint, Solve
from rfms_can.setpoint.succession import FOLLOWS

__all__ = ["FOLLOWS", "CartesianSetpoint", "JointSetpoint", "Solve"]
