"""Direct kinematics (A.16, with a3)."""

import math
from collections.abc import Sequence

from rfms_can.kinematics.geometry import Geometry
from rfms_can.transform import Transform


def direct(arm: Geometry, q: Sequence[float]) -> Transform:
    """T6 of the joint angles ``q`` (radians): the wrist centre's frame in the base frame.

    Joint limits are not checked: the direct solution exists for every angle. The origin of the base
    frame is on the joint-2 axis; pedestal, flange and tool are transforms of the user.
    """
    sin, cos = math.sin, math.cos
    q1, q2, q3, q4, q5, q6 = q
    s1, c1, s23, c23 = sin(q1), cos(q1), sin(q2 + q3), cos(q2 + q3)
    s4, c4, s5, c5, s6, c6 = sin(q4), cos(q4), sin(q5), cos(q5), sin(q6), cos(q6)
    a2, a3, d4, d = arm.a2, arm.a3, arm.d4, arm.shoulder_offset
    u511, u512 = c5 * c6, -c5 * s6
    u521, u522 = s5 * c6, -s5 * s6
    u411, u421 = c4 * u511 - s4 * s6, s4 * u511 + c4 * s6
    u412, u422 = c4 * u512 - s4 * c6, s4 * u512 + c4 * c6
    u413, u423 = -c4 * s5, -s4 * s5
    u211, nz = c23 * u411 - s23 * u521, s23 * u411 + c23 * u521
    u212, oz = c23 * u412 - s23 * u522, s23 * u412 + c23 * u522
    u213, az = c23 * u413 - s23 * c5, s23 * u413 + c23 * c5
    u214 = a2 * cos(q2) + a3 * c23 - d4 * s23
    pz = a2 * sin(q2) + a3 * s23 + d4 * c23
    return tuple.__new__(
        Transform,
        (
            *(c1 * u211 - s1 * u421, c1 * u212 - s1 * u422, c1 * u213 - s1 * u423),
            c1 * u214 + s1 * d,
            *(s1 * u211 + c1 * u421, s1 * u212 + c1 * u422, s1 * u213 + c1 * u423),
            s1 * u214 - c1 * d,
            *(nz, oz, az),
            pz,
        ),
    )
