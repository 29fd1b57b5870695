"""Range of the force/torque sensor between hand and tool (P: JR3 and Lord, 1986)."""

from typing import Final

FORCE_RANGE: Final = 400.0
"""Along each axis, N."""
TORQUE_RANGE: Final = 40.0
"""About each axis, Nm."""
SENSOR_RANGE: Final = (FORCE_RANGE,) * 3 + (TORQUE_RANGE,) * 3
