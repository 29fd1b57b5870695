"""Set-points: of the hand, one a cycle on the bus, and of each joint, which every node makes of it.

``cartesian.py`` is what the master says, ``frames.py`` its two frames, ``succession.py`` in which
order, ``joint.py`` what a joint makes of it, with the polynomials of ``blend.py`` and the
derivatives of ``history.py``.
"""

from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.setpoint.joint import JointSetpoint, Solve
from rfms_can.setpoint.succession import FOLLOWS

__all__ = ["FOLLOWS", "CartesianSetpoint", "JointSetpoint", "Solve"]
