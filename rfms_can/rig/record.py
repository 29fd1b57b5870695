"""A recorded run: a directory with the frames, the settings and versions, and the numbers.

``bus.log``        every frame, as ``candump -L`` writes it
``settings.json``  settings, versions, and the arm's data needed to read the log
``commanded.csv``  the commanded joint angles of every cycle, rad, in double precision
``summary.json``   the result
``truth.csv``      ground truth of each cycle: with a scene, on the simulated bus
``terms.npz``      terms of the joints' torques, if recorded (``rig/torque_terms.py``)
"""

import json
import platform
from array import array
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, Final

from rfms_can import __version__
from rfms_can.arm import Arm
from rfms_can.errors import RfmsError
from rfms_can.rig.result import RunResult
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.torque_terms import TERMS, TermsRecorder
from rfms_can.rig.truth import COLUMNS, Truth
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS

LOG: Final = "bus.log"
SETTINGS: Final = "settings.json"
COMMANDED: Final = "commanded.csv"
SUMMARY: Final = "summary.json"
TRUTH: Final = "truth.csv"
_FILES: Final = (LOG, SETTINGS, COMMANDED, SUMMARY, TRUTH, TERMS)
_PACKAGES: Final = ("numpy", "python-can", "cantools", "pin", "mujoco", "autosar-e2e", "msgspec")


class Record:
    """Writes a run's directory.

    Args:
        directory: made if it does not exist; an earlier recording in it is replaced.

    Raises:
        RfmsError: it cannot be written.
    """

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        try:
            directory.mkdir(parents=True, exist_ok=True)
            for name in _FILES:
                (directory / name).unlink(missing_ok=True)
            (directory / LOG).write_bytes(b"")
        except OSError as error:
            raise RfmsError(f"--record {directory}: {error.strerror}; name a directory") from error

    @property
    def log(self) -> Path:
        """The candump log."""
        return self.directory / LOG

    def settings(self, settings: RunSettings, arm: Arm, zero_counts: list[int]) -> None:
        """Settings and versions."""
        self._json(
            SETTINGS,
            {
                "settings": settings.as_dict(),
                "zero_counts": zero_counts,
                "counts_per_radian": [drive.counts_per_radian for drive in arm.drives],
                "dbc_hash": Wire().dbc_hash,
                "versions": versions(),
            },
        )

    def commanded(self, angles: "array[float]") -> None:
        """Six joint angles a cycle, rad."""
        width = len(JOINTS)
        lines = ["cycle," + ",".join(f"q{joint}" for joint in JOINTS)]
        lines += [
            f"{start // width}," + ",".join(map(repr, angles[start : start + width]))
            for start in range(0, len(angles), width)
        ]
        self._write(COMMANDED, "\n".join(lines) + "\n")

    def truth(self, rows: Sequence[Truth]) -> None:
        """Ground truth of each cycle."""
        lines = [",".join(COLUMNS), *(",".join(map(repr, row.row())) for row in rows)]
        self._write(TRUTH, "\n".join(lines) + "\n")

    def terms(self, recorder: TermsRecorder) -> None:
        """What the joints' torques were made of."""
        path = self.directory / TERMS
        try:
            recorder.save(path)
        except OSError as error:
            raise RfmsError(f"--terms: {path} cannot be written: {error.strerror}") from error

    def summary(self, result: RunResult) -> None:
        """The numbers."""
        self._json(SUMMARY, result.as_dict())

    def _json(self, name: str, value: dict[str, Any]) -> None:
        self._write(name, json.dumps(value, indent=2) + "\n")

    def _write(self, name: str, text: str) -> None:
        path = self.directory / name
        try:
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise RfmsError(f"--record: {path} cannot be written: {error.strerror}") from error


def versions() -> dict[str, str]:
    """Versions of Python, of this package and of its dependencies."""
    found = {"python": platform.python_version(), "rfms_can": __version__}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "unknown"
    return found
