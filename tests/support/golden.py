"""Reads the reference numbers of ``tests/golden``, and measures how far from them something is."""

import gzip
import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rfms_can import arm as arms
from rfms_can.transform import Transform

GOLDEN = Path(__file__).parents[1] / "golden"
ARMS = tuple(arms.ARMS.values())


@cache
def golden(name: str) -> Any:
    """A file's content, read once for all: change nothing in it. README.md there explains each."""
    packed = GOLDEN / f"{name}.json.gz"
    if packed.exists():
        return json.loads(gzip.decompress(packed.read_bytes()))
    return json.loads((GOLDEN / f"{name}.json").read_text("utf-8"))


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
