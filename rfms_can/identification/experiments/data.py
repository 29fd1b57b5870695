"""An experiment's data on disk: one file, written atomically after the experiment."""

import hashlib
import json
import os
import struct
import zipfile
import zlib
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np

from rfms_can.errors import RfmsError
from rfms_can.identification.experiments.actions import Mark
from rfms_can.identification.experiments.plan import Experiment
from rfms_can.identification.experiments.tap import Integers
from rfms_can.rig.settings import RunSettings

SUFFIX: Final = ".npz"
BROKEN: Final = (
    *(OSError, ValueError, KeyError, TypeError, EOFError, NotImplementedError, RuntimeError),
    *(zipfile.BadZipFile, zlib.error, struct.error, msgspec.MsgspecError),
)
"""What reading raises for a file that was cut or damaged, depending on where."""
SAMPLE_SHAPE: Final = (4, 6)
"""Of one cycle: counts, current ADC, velocity ADC and DAC of six joints."""


class DataError(RfmsError):
    """Data that cannot be read or written, or are of another experiment."""


class Data(NamedTuple):
    """Data of an experiment.

    Attributes:
        table: (cycles, 4, 6): counts, current ADC, velocity ADC, DAC.
        zero_counts: encoder counts at joint angle 0, from homing (6).
        marks: of its motions.
        period_s: control period, s.
        load: whether the known load was in the hand.
    """

    table: Integers
    zero_counts: tuple[int, ...]
    marks: tuple[Mark, ...]
    period_s: float
    load: bool


def fingerprint(experiment: Experiment, settings: RunSettings) -> str:
    """Digest of an experiment: its actions and its settings."""
    what = json.dumps([asdict(experiment), settings.as_dict()], sort_keys=True)
    return hashlib.sha256(what.encode()).hexdigest()[:16]


def save(path: Path, data: Data, digest: str) -> None:
    """Write a file atomically.

    Raises:
        DataError: it cannot be written.
    """
    about = {
        "fingerprint": digest,
        "zero_counts": data.zero_counts,
        "marks": [asdict(mark) for mark in data.marks],
        "period_s": data.period_s,
        "load": data.load,
    }
    temporary = path.with_suffix(".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with temporary.open("wb") as file:
            np.savez_compressed(file, table=data.table, about=np.array(json.dumps(about)))
        os.replace(temporary, path)
    except OSError as error:
        raise DataError(f"data {path}: {error.strerror}; name another directory") from error


class _About(msgspec.Struct):
    fingerprint: str
    zero_counts: tuple[int, ...]
    marks: list[dict[str, Any]]
    period_s: float
    load: bool


def load(path: Path, digest: str) -> Data | None:
    """Read a file; None if it does not exist.

    Raises:
        DataError: it is broken, or of another experiment, arm or plant.
    """
    if not path.exists():
        return None
    try:
        with np.load(path) as file:
            table = file["table"]
            about = msgspec.json.decode(str(file["about"]), type=_About)
            if table.shape[1:] != SAMPLE_SHAPE or table.dtype.kind != "i":
                raise ValueError(f"its table is {table.shape} {table.dtype}")
            marks = tuple(Mark(**mark) for mark in about.marks)
    except BROKEN as error:
        reason = str(error) or type(error).__name__
        raise DataError(f"data {path}: {reason}; remove it, or name another directory") from error
    if about.fingerprint != digest:
        raise DataError(
            f"data {path}: made by another experiment, arm, plant or rate; name another directory "
            f"with --data"
        )
    return Data(table, about.zero_counts, marks, about.period_s, about.load)
