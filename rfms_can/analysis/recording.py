"""A recorded run, read back: what ``rfms run --record DIR`` wrote, as arrays in SI units."""

import zipfile
import zlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Final, TypeVar

import msgspec
import numpy as np

from rfms_can.analysis.cycles import CycleLog, Floats, read_cycles
from rfms_can.arm import JOINT_COUNT, Arm, arm_by_name
from rfms_can.bus.budget import Cycle, contract_streams
from rfms_can.bus.schedule import load
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import RfmsError
from rfms_can.joint_nodes.servo import ServoTerms
from rfms_can.rig.candump import read_candump
from rfms_can.rig.torque_terms import NAMES, TERMS, joint_key
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import HEARTBEAT_EVERY

LOG: Final = "bus.log"
SETTINGS: Final = "settings.json"
SUMMARY: Final = "summary.json"
COMMANDED: Final = "commanded.csv"

LOAD_WINDOW_S: Final = 0.05
"""Bus load is averaged over about this time: whole rounds of heartbeats."""


class RecordingError(RfmsError):
    """A directory that holds no recorded run, or not a whole one."""


_Kind = TypeVar("_Kind", bound=msgspec.Struct)
_Positive = Annotated[float, msgspec.Meta(gt=0.0)]
_Six = tuple[int, int, int, int, int, int]
_SixFloats = tuple[float, float, float, float, float, float]


class _Settings(msgspec.Struct):
    """What plots need of a run's settings."""

    arm: str
    rate: _Positive
    bit_rate: int = 1_000_000
    data_bit_rate: int = 5_000_000
    blend: str = "continuous"


class _SettingsFile(msgspec.Struct):
    """``settings.json``."""

    settings: _Settings
    zero_counts: _Six
    counts_per_radian: _SixFloats


class Summary(msgspec.Struct):
    """What plots need of ``summary.json``."""

    fault: str | None = None
    bus_load: float | None = None
    bus_bound: float | None = None
    incomplete: int = 0


@dataclass(frozen=True, eq=False)
class TorqueTerms:
    """What the torques of one joint were made of.

    Attributes:
        cycle: of each torque, since enable (N).
        terms: Nm, by name of the term (N each); they add up to the torque.
    """

    cycle: Floats
    terms: dict[str, Floats]

    @property
    def torque(self) -> Floats:
        """Their sum, Nm (N)."""
        total: Floats = np.sum(list(self.terms.values()), axis=0, dtype=np.float64)
        return total


@dataclass(frozen=True, eq=False)
class Recording:
    """One run, from the enabling of the arm to its disabling.

    Attributes:
        directory: where it was read from.
        arm: the arm that ran.
        period_s: control period, s.
        log: the bus log, cycle by cycle.
        commanded: the master's trajectory in double precision, one row a cycle, rad (C, 6).
        summary: the run's own numbers.
        bus_bound: worst-case load of a cycle, part of the bus time.
        zero_counts, counts_per_radian: of the encoders (6).
        terms: of each joint's torques, if they were recorded.
        blend: matching polynomial of its transitions, ``continuous`` or ``thesis``.
    """

    directory: Path
    arm: Arm
    period_s: float
    log: CycleLog
    commanded: Floats
    summary: Summary
    bus_bound: float
    zero_counts: Floats
    counts_per_radian: Floats
    terms: "tuple[TorqueTerms, ...] | None" = None
    blend: str = "continuous"

    @cached_property
    def time(self) -> Floats:
        """Start of each logged cycle since enable, s (N)."""
        return np.multiply(self.log.cycle, self.period_s, dtype=np.float64)

    @cached_property
    def commanded_time(self) -> Floats:
        """Time of each row of ``commanded``, s (C)."""
        return np.multiply(np.arange(len(self.commanded)), self.period_s, dtype=np.float64)

    @cached_property
    def q(self) -> Floats:
        """Measured joint angles, rad (N, 6)."""
        return (self.log.counts - self.zero_counts) / self.counts_per_radian

    @cached_property
    def speed(self) -> Floats:
        """Joint speeds by the velocity ADC, rad/s (N, 6)."""
        boards = map(self.arm.board_scale, range(JOINT_COUNT))
        scales: Floats = np.array([board.speed_per_adc_code for board in boards])
        return self.log.velocity_codes * scales

    @cached_property
    def error_counts(self) -> Floats:
        """Tracking errors, set-point less encoder, in encoder counts (N, 6)."""
        return self.log.errors * np.abs(self.counts_per_radian)

    @cached_property
    def torque(self) -> Floats:
        """Joint torques as written to the motor-current DACs, Nm (N, 6)."""
        boards = map(self.arm.board_scale, range(JOINT_COUNT))
        scales: Floats = np.array([board.torque_per_dac_code for board in boards])
        return self.log.current_codes * scales

    def derivative(self, order: int) -> Floats:
        """Central differences of the commanded trajectory, rad/s^order (C, 6); NaN at both ends.

        Order 1 velocity, 2 acceleration, 3 jerk; error O(T^2), rounding below 1e-7 rad/s3 at 4 ms.
        """
        stencil = _STENCILS[order]
        width = len(stencil)
        rates: Floats = np.full_like(self.commanded, np.nan)
        if len(self.commanded) >= width:
            windows = np.lib.stride_tricks.sliding_window_view(self.commanded, width, axis=0)
            half = width // 2
            rates[half : len(rates) - half] = windows @ stencil / self.period_s**order
        return rates

    @property
    def load_window(self) -> int:
        """Cycles over which bus load is averaged: whole rounds of heartbeats, so it is even."""
        return HEARTBEAT_EVERY * max(1, round(LOAD_WINDOW_S / (HEARTBEAT_EVERY * self.period_s)))

    def bus_load(self) -> tuple[Floats, Floats]:
        """Time of each window's middle, s, and its load: bus time of its frames, part of it."""
        window = self.load_window
        parts = self.log.busy_ns * 1e-9 / self.period_s
        whole = len(parts) // window * window
        middle = self.time[:whole].reshape(-1, window).mean(axis=1) + 0.5 * self.period_s
        return middle, parts[:whole].reshape(-1, window).mean(axis=1, dtype=np.float64)


_STENCILS: Final = {
    1: np.array([-0.5, 0.0, 0.5]),
    2: np.array([1.0, -2.0, 1.0]),
    3: np.array([-0.5, 1.0, 0.0, -1.0, 0.5]),
}
"""Weights of central differences by order of the derivative."""


def load_recording(directory: Path, wire: Wire | None = None) -> Recording:
    """Read a recorded run.

    Raises:
        RecordingError: no such directory, a missing or broken file, or a log of another bus.
        ArmError: an arm this version does not know.
    """
    _check_files(directory)
    about = _read_json(directory / SETTINGS, _SettingsFile)
    settings = about.settings
    timing = BusTiming(settings.bit_rate, settings.data_bit_rate)
    summary = _read_json(directory / SUMMARY, Summary)
    return Recording(
        directory=directory,
        arm=arm_by_name(settings.arm),
        period_s=1.0 / settings.rate,
        log=_read_log(directory / LOG, wire or Wire(), timing),
        commanded=_read_commanded(directory / COMMANDED),
        summary=summary,
        bus_bound=summary.bus_bound or _bound(settings.rate, timing),
        zero_counts=np.array(about.zero_counts, dtype=np.float64),
        counts_per_radian=np.array(about.counts_per_radian),
        terms=_read_terms(directory / TERMS),
        blend=settings.blend,
    )


def _check_files(directory: Path) -> None:
    if not directory.is_dir():
        raise RecordingError(
            f"{directory} is not a directory: give the one written by rfms run --record"
        )
    missing = [
        name for name in (LOG, SETTINGS, SUMMARY, COMMANDED) if not (directory / name).is_file()
    ]
    if missing:
        raise RecordingError(
            f"{directory} holds no recorded run: {', '.join(missing)} missing; "
            f"record one with rfms run PROGRAM --record {directory}"
        )


def _read_json(path: Path, kind: type[_Kind]) -> _Kind:
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except (msgspec.MsgspecError, OSError, UnicodeDecodeError) as error:
        raise RecordingError(f"{path}: {error}") from error


def _read_log(path: Path, wire: Wire, timing: BusTiming) -> CycleLog:
    try:
        frames = read_candump(path)
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path}: no candump log but binary data") from error
    except (ValueError, OSError) as error:
        raise RecordingError(str(error)) from error
    log = read_cycles((frame for _, frame in frames), wire, timing)
    if not len(log.cycle):
        raise RecordingError(
            f"{path}: none of its {log.frames} frames is a SYNC of an enabled arm (DBC "
            f"{wire.dbc_hash:#06x}); a log of another DBC needs the version that recorded it"
        )
    return log


def _read_commanded(path: Path) -> Floats:
    try:
        lines = path.read_text(encoding="ascii").splitlines()[1:]
        table = (
            np.loadtxt(lines, delimiter=",", ndmin=2) if lines else np.empty((0, 1 + JOINT_COUNT))
        )
    except (ValueError, OSError) as error:
        raise RecordingError(f"{path}: {error}") from error
    if table.shape[1] != 1 + JOINT_COUNT or not np.array_equal(table[:, 0], np.arange(len(table))):
        raise RecordingError(f"{path}: rows must be cycle,q1,...,q6 with cycles 0, 1, 2, ...")
    return np.ascontiguousarray(table[:, 1:])


def _read_terms(path: Path) -> tuple[TorqueTerms, ...] | None:
    """``terms.npz``, or None where no terms were recorded."""
    if not path.exists():
        return None
    try:
        with np.load(path, allow_pickle=False) as file:
            names = [str(name) for name in file[NAMES]]
            tables = [file[joint_key(joint + 1)] for joint in range(JOINT_COUNT)]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise RecordingError(f"{path}: {error}; record it again with rfms run --terms") from error
    if names != list(ServoTerms._fields) or any(t.shape[1:] != (1 + len(names),) for t in tables):
        raise RecordingError(f"{path}: terms of another version; record it with this one")
    return tuple(
        TorqueTerms(table[:, 0], dict(zip(names, table[:, 1:].T, strict=True))) for table in tables
    )


def _bound(rate_hz: float, timing: BusTiming) -> float:
    """Worst-case load of the usual cycle, where the summary names none."""
    return load(contract_streams(rate_hz, timing, cycle=Cycle.USUAL), timing)
