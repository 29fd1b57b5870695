"""``rfms doctor``: which features this machine supports, and how to enable the others."""

import ctypes
import json
import os
import platform
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Annotated, Final

import typer
from rich.console import Console

from rfms_can.errors import DbcError

PACKAGES: Final = {
    "numpy": "numpy",
    "python-can": "can",
    "cantools": "cantools",
    "autosar-e2e": "e2e",
    "pin": "pinocchio",
    "mujoco": "mujoco",
    "msgspec": "msgspec",
    "pyzmq": "zmq",
    "typer": "typer",
    "rich": "rich",
}
"""Packages a run needs: distribution and module."""

OPTIONAL_PACKAGES: Final = {"matplotlib": "matplotlib", "ruckig": "ruckig"}
OLDEST_PYTHON: Final = (3, 11)
CAN_UTILS: Final = ("candump", "cansend", "canplayer", "cangw")
USER_MODE_KERNEL: Final = "linux.uml"
NETWORK_INTERFACES: Final = Path("/sys/class/net")

_ARPHRD_CAN: Final = 280  # linux/if_arp.h
_MCL_CURRENT, _MCL_ONFAULT = 1, 4  # sys/mman.h
_IMPORT: Final = """
import importlib, sys, time
for module in sys.argv[1:]:
    begin = time.perf_counter()
    importlib.import_module(module)
    print(module, time.perf_counter() - begin, flush=True)
"""


@dataclass(frozen=True, slots=True)
class Finding:
    """Result of one check.

    Attributes:
        name: of the feature.
        good: whether it is available.
        detail: version or reason.
        advice: how to make it available.
        needed: whether the default run needs it.
    """

    name: str
    good: bool
    detail: str
    advice: str = ""
    needed: bool = False


def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object")] = False,
) -> None:
    """Check what this machine supports. Exit code 1 if the default run lacks something."""
    findings = list(examine())
    ready = all(finding.good for finding in findings if finding.needed)
    if as_json:
        checks = {finding.name: asdict(finding) for finding in findings}
        typer.echo(json.dumps({"ready": ready, "checks": checks}))
    else:
        _print(findings, ready)
    if not ready:
        raise typer.Exit(1)


def examine() -> Iterator[Finding]:
    """Run all checks, those a run needs first."""
    yield python()
    yield from (package(*names, needed=True) for names in PACKAGES.items())
    yield from (package(*names, needed=False) for names in OPTIONAL_PACKAGES.items())
    yield contract()
    for look in (processors, socketcan, vcan, user_mode_kernel, can_utils, real_time, memory_lock):
        yield look()


def python() -> Finding:
    """The interpreter."""
    oldest = ".".join(map(str, OLDEST_PYTHON))
    return Finding(
        "Python",
        sys.version_info >= OLDEST_PYTHON,
        f"{platform.python_version()}, {sys.executable}",
        f"{oldest} or newer is needed",
        needed=True,
    )


def package(distribution: str, module: str, *, needed: bool) -> Finding:
    """A package: its version, and how long it takes to import in a process of its own."""
    advice = f"pip install {distribution}"
    try:
        version = metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return Finding(distribution, False, "not installed", advice, needed)
    done = subprocess.run(
        [sys.executable, "-c", _IMPORT, module], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
        return Finding(distribution, False, f"{version} fails: {last}", advice, needed)
    seconds = float(done.stdout.split()[-1])
    return Finding(distribution, True, f"{version}, imports in {seconds:.2f} s", needed=needed)


def contract() -> Finding:
    """The DBC; imported here, so that a broken package is reported instead of raising."""
    try:
        from rfms_can.wire.codec import database_hash, database_path, load_database

        database = load_database()
    except (DbcError, ImportError, OSError) as error:
        return Finding("wire contract", False, str(error), "install rfms_can again", needed=True)
    detail = f"{len(database.messages)} messages, hash 0x{database_hash():04X}, {database_path()}"
    return Finding("wire contract", True, detail, needed=True)


def processors() -> Finding:
    """Number of processors, and number this process may use."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    detail = f"{os.cpu_count()}, {usable} usable; {platform.machine()}, kernel {platform.release()}"
    return Finding("processors", True, detail)


def socketcan() -> Finding:
    """CAN in the kernel, and its interfaces."""
    if not hasattr(socket, "AF_CAN"):
        return Finding("SocketCAN", False, f"{platform.system()} has none", "--bus hub:NAME")
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError as error:
        return Finding("SocketCAN", False, error.strerror or str(error), _vcan_advice())
    interfaces = ", ".join(can_interfaces()) or "none"
    return Finding("SocketCAN", True, f"interfaces: {interfaces}")


def can_interfaces(directory: Path = NETWORK_INTERFACES) -> Iterator[str]:
    """Names of the CAN interfaces of this machine."""
    for kind in sorted(directory.glob("*/type")):
        with suppress(OSError):
            if int(kind.read_text()) == _ARPHRD_CAN:
                yield kind.parent.name


def vcan() -> Finding:
    """The virtual CAN interface: up, or a module of the running kernel."""
    if "vcan0" in can_interfaces():
        return Finding("vcan", True, "vcan0 exists")
    modules = Path("/lib/modules", platform.release())
    for file in ("modules.dep", "modules.builtin"):
        with suppress(OSError):
            if "/vcan.ko" in (modules / file).read_text():
                return Finding("vcan", True, f"a module of this kernel ({modules / file})")
    return Finding("vcan", False, f"no module of kernel {platform.release()}", _vcan_advice())


def _vcan_advice() -> str:
    """How to get vcan0 where the kernel has none."""
    if shutil.which(USER_MODE_KERNEL):
        return "tools/with-vcan COMMAND runs it on a real vcan0, in the user-mode kernel"
    return "Debian: sudo apt-get install user-mode-linux can-utils, then tools/with-vcan COMMAND"


def user_mode_kernel() -> Finding:
    """The kernel ``tools/with-vcan`` boots where this one has no vcan."""
    path = shutil.which(USER_MODE_KERNEL)
    detail = path or f"no {USER_MODE_KERNEL}"
    return Finding("user-mode kernel", path is not None, detail, _vcan_advice())


def can_utils() -> Finding:
    """candump and the other can-utils."""
    missing = [program for program in CAN_UTILS if shutil.which(program) is None]
    detail = f"no {', '.join(missing)}" if missing else ", ".join(CAN_UTILS)
    return Finding("can-utils", not missing, detail, "sudo apt-get install can-utils")


def real_time() -> Finding:
    """SCHED_FIFO: tried, then reset."""
    advice = "for --clock realtime: ulimit -r 50, or CAP_SYS_NICE"
    if not hasattr(os, "sched_setscheduler"):
        return Finding("SCHED_FIFO", False, f"{platform.system()} has none", advice)
    policy, priority = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except OSError as error:
        return Finding("SCHED_FIFO", False, error.strerror or str(error), advice)
    os.sched_setscheduler(0, policy, priority)
    return Finding("SCHED_FIFO", True, "permitted")


def memory_lock() -> Finding:
    """mlockall: tried, and undone."""
    advice = "for --clock realtime: ulimit -l unlimited, or CAP_IPC_LOCK"
    try:
        library = ctypes.CDLL(None, use_errno=True)
        lock, unlock = library.mlockall, library.munlockall
    except (OSError, AttributeError):
        return Finding("mlockall", False, f"{platform.system()} has none", advice)
    if lock(_MCL_CURRENT | _MCL_ONFAULT) != 0:
        return Finding("mlockall", False, os.strerror(ctypes.get_errno()), advice)
    unlock()
    return Finding("mlockall", True, "permitted")


def _print(findings: list[Finding], ready: bool) -> None:
    console = Console(soft_wrap=True, highlight=False, markup=False)
    width = max(len(finding.name) for finding in findings)
    for finding in findings:
        word, style = ("yes", "green") if finding.good else ("no", "yellow")
        if finding.needed and not finding.good:
            word, style = "MISSING", "bold red"
        console.print(f"{word:8}", style=style, end="")
        console.print(f"{finding.name:{width}}  {finding.detail}")
        if not finding.good:
            console.print(f"{'':{width + 8}}  {finding.advice}", style="dim")
    console.print("the default run works here" if ready else "the default run does NOT work here")
