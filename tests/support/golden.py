"""The kinematics' reference numbers, read once, and the small linear algebra tests need."""

import gzip
import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rfms_can.arm import PUMA_260, PUMA_560
from rfms_can.transform import Transform

GOLDEN = Path(__file__).parents[1] / "golden"
ARMS = (PUMA_260, PUMA_560)


@cache
def golden(name: str) -> dict[str, list[dict[str, Any]]]:
    content: dict[str, list[dict[str, Any]]] = json.loads(
        gzip.decompress((GOLDEN / f"{name}.json.gz").read_bytes())
    )
    return content


def matrix(rows: object) -> NDArray[np.float64]:
    return np.array(rows, dtype=np.float64)


def homogeneous(t: Transform) -> NDArray[np.float64]:
    return np.vstack([t.rows(), [0.0, 0.0, 0.0, 1.0]])


def distance(a: Sequence[float], b: Sequence[float]) -> float:
    """Largest difference, element by element."""
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


def turned_distance(a: Sequence[float], b: Sequence[float]) -> float:
    """Largest difference of angles, whole turns aside."""
    differences = np.array(a) - np.array(b)
    return float(np.abs(np.arctan2(np.sin(differences), np.cos(differences))).max())
