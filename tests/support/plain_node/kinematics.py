"""docs/node-kinematics.md: the inverse solution."""

import math
from collections.abc import Sequence

import numpy as np

Numbers = Sequence[float]
NAN = math.nan


def pose_of(o: Numbers, a: Numbers) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """n, o, a, orthonormal; None for no pose."""
    ov, av = np.array(o, float), np.array(a, float)
    aa, oo, oa = av @ av, ov @ ov, ov @ av
    if not (abs(aa - 1) < 1e-5 and abs(oo - 1) < 1e-5 and abs(oa) < 1e-5):
        return None
    av = av / math.sqrt(aa)
    ov = ov - oa / math.sqrt(aa) * av
    ov = ov / math.sqrt(ov @ ov)
    return np.cross(ov, av), ov, av


def link(a: float, d: float, alpha: float, theta: float) -> np.ndarray:
    """Rz(theta) Tz(d) Tx(a) Rx(alpha)."""
    ct, st, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
    return np.array(
        [
            [ct, -st * ca, st * sa, a * ct],
            [st, ct * ca, -ct * sa, a * st],
            [0.0, sa, ca, d],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def solve_all(
    lengths: Numbers, o: Numbers, a: Numbers, p: Numbers, code: int, held: float = 0.0
) -> list[float]:
    """Six angles without turns; NaN where there is no solution."""
    a2, a3, d4, d = lengths
    frame = pose_of(o, a)
    if frame is None:
        return [NAN] * 6
    _, (ox, oy, oz), (ax, ay, az) = frame
    px, py, pz = p
    right, down, flip = code & 1, code & 2, code & 4
    L2 = a3 * a3 + d4 * d4
    L, phi, e = math.sqrt(L2), math.atan2(d4, a3), 1e-6
    q = px * px + py * py
    if q < max(abs(d) - e, 1e-6) ** 2:
        return [NAN] * 6
    V114 = math.sqrt(max(q - d * d, 0.0))
    V114 = -V114 if right else V114
    s = 1.0 / math.sqrt(q * (V114 * V114 + d * d))
    C1, S1 = (V114 * px - d * py) * s, (V114 * py + d * px) * s
    theta1 = math.atan2(S1, C1)
    rho2 = V114 * V114 + pz * pz
    if rho2 < max(abs(a2 - L) - e, 1e-6) ** 2 or rho2 > (a2 + L + e) ** 2:
        return [theta1, *[NAN] * 5]
    K = rho2 + (a2 - L) * (a2 + L)
    M = math.sqrt(max(((a2 + L) ** 2 - rho2) * (rho2 - (a2 - L) ** 2), 0.0))
    M = -M if down else M
    theta2 = math.atan2(K * pz - M * V114, K * V114 + M * pz)
    theta3 = math.atan2(M, rho2 - (a2 * a2 + L2)) - phi
    x = V114 - (K * V114 + M * pz) / (2 * rho2)
    y = pz - (K * pz - M * V114) / (2 * rho2)
    C23, S23 = (x * a3 + y * d4) / L2, (y * a3 - x * d4) / L2
    V113 = C1 * ax + S1 * ay
    V313, V323 = C23 * V113 + S23 * az, C1 * ay - S1 * ax
    C5 = C23 * az - S23 * V113
    h = math.sqrt(V313 * V313 + V323 * V323)
    if h < 1e-5:
        C4, S4 = math.cos(held), math.sin(held)
    else:
        C4, S4 = V313 / h, V323 / h
        if not flip:
            C4, S4 = -C4, -S4
    S5 = -C4 * V313 - S4 * V323
    V112, V132 = C1 * ox + S1 * oy, S1 * ox - C1 * oy
    V312, V332 = C23 * V112 + S23 * oz, C23 * oz - S23 * V112
    S6 = C5 * (S4 * V132 - C4 * V312) - S5 * V332
    C6 = -S4 * V312 - C4 * V132
    wrist = [math.atan2(S4, C4), math.atan2(S5, C5), math.atan2(S6, C6)]
    return [theta1, theta2, theta3, *wrist]


def turn(angle: float, previous: float, low: float, high: float) -> float:
    """The turn that is taken; NaN for none."""
    b = angle - previous
    if -math.pi <= b <= math.pi and low <= angle <= high:
        return angle
    if not math.isfinite(b):
        return NAN
    angle -= 2 * math.pi * round(b / (2 * math.pi))
    if angle > high:
        angle -= 2 * math.pi * math.ceil((angle - high) / (2 * math.pi))
    elif angle < low:
        angle += 2 * math.pi * math.ceil((low - angle) / (2 * math.pi))
    return angle if low <= angle <= high else NAN
