"""Appendix B as corrected: the constants from masses, centres of mass and radii of gyration.

The thesis takes centres of mass on one axis of each link (B.1, B.2) and radii of gyration about the
*link frame*. Corrections, each held against the full model by a test:

* B.6 c21: m2 (x2 + a2) instead of m2 x2; B.9 b40: k5zz and k6zz; b41, which has no formula.
* B.10 b30: m6 (d4^2 + a3^2 + k6xx) instead of m6 (d4^2 + d3^2).
* B.12 b20: (m3 + ... + m6) a2^2 and m6 k6xx are missing.
* B.13, B.14: b25 and b26 are interchanged, and b26 has no mass in it.
* B.21 b230: -2 m4 y4 d4 instead of +(2 m4 y4 + m6 z6) d4; B.23 b232: -y4 a2 m4.
"""

from typing import NamedTuple

from rfms_can.arm import Arm, Link
from rfms_can.dynamics.terms import in_other_convention

GRAVITY_M_S2 = 9.81


class _Gyration(NamedTuple):
    """m k^2 of a link about the axes of its own frame, kg m2."""

    xx: float
    yy: float
    zz: float


def appendix_b(arm: Arm) -> dict[str, float]:
    """Constants of the simplified dynamics, convention B, Nm and kg m2, with the drives' Ia.

    Components of the links' centres of mass off the axes of B.1 and B.2 are neglected.
    """
    _, l2, l3, l4, l5, l6 = arm.links
    a2, a3, d3, d4 = arm.a2, -arm.a3, arm.shoulder_offset, arm.d4  # convention A
    x2, z3, y4, z5, z6 = l2.com[0], l3.com[2], -l4.com[1], l5.com[2], l6.com[2]
    k1, k2, k3, k4, k5, k6 = (_gyration(link) for link in arm.links)
    hand, forearm = l5.mass * z5 + l6.mass * z6, l4.mass + l5.mass + l6.mass
    beyond = l3.mass + forearm
    lever = l3.mass * z3 + forearm * d4 - l4.mass * y4
    turning = k3.yy + k4.xx + k5.xx + k6.xx + forearm * d4**2 - 2.0 * l4.mass * y4 * d4
    turning += beyond * a3**2
    g = GRAVITY_M_S2
    constants = {
        "c21": -(l2.mass * (x2 + a2) + beyond * a2) * g,
        "c22": 0.0,
        "c31": -beyond * a3 * g,
        "c32": -lever * g,
        "c50": -hand * g,
        "b10": k1.yy
        + k2.xx
        + k3.xx
        + k4.xx
        + k5.xx
        + k6.xx
        + beyond * d3**2
        + forearm * d4**2
        - 2.0 * l4.mass * y4 * d4,
        "b11": (l2.mass + beyond) * a2**2 + 2.0 * l2.mass * x2 * a2 + k2.yy - k2.xx,
        "b12": beyond * a3**2 - forearm * d4**2 + 2.0 * l4.mass * y4 * d4 + k3.zz - k3.xx,
        "b13": 2.0 * beyond * a3 * a2,
        "b14": 2.0 * a2 * lever,
        "b15": 2.0 * a3 * lever,
        "b20": k2.zz + l2.mass * (a2**2 + 2.0 * x2 * a2) + beyond * a2**2 + turning,
        "b25": 2.0 * a2 * a3 * beyond,
        "b26": 2.0 * a2 * lever,
        "b30": turning,
        "b31": 2.0 * hand * d4,
        "b40": k4.yy + k5.zz + k6.zz,
        "b41": k5.xx - k5.zz + k6.xx - k6.zz,
        "b50": k5.yy + k6.xx,
        "b60": k6.zz,
        "b230": turning,
        "b231": beyond * a2 * a3,
        "b232": a2 * lever,
    }
    for joint, drive in enumerate(arm.drives, start=1):
        constants[f"b{joint}0"] += drive.armature
    return in_other_convention(constants)


def _gyration(link: Link) -> _Gyration:
    """From the inertia about the centre of mass to that about the link frame."""
    x, y, z = link.com
    xx, yy, zz = link.inertia
    m = link.mass
    return _Gyration(xx + m * (y * y + z * z), yy + m * (x * x + z * z), zz + m * (x * x + y * y))
