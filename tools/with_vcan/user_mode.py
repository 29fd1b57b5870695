"""A user-mode Linux kernel: an ordinary program that boots in two seconds and has vcan.

Its root file system is this machine's. What the command inside prints leaves over serial lines,
which are pipes to this process; the kernel's own messages go to a log, shown only if it fails.
"""

import json
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from . import Obstacle
from .guard import guarding
from .init import Job, Outcome
from .native import find_ip
from .processor import idlest_processor
from .relay import Ended, ending_signals, relay

INIT = Path(__file__).with_name("init.py")
MODULES = ("can", "can-raw", "can-bcm", "can-gw", "vcan")
HIDDEN = ("/dev", "/proc", "/run", "/sys")
"""What the kernel inside has of its own: nothing below is shared with this machine."""


class KernelError(Exception):
    """The user-mode kernel failed, not the command."""


@dataclass(frozen=True)
class Kernel:
    """A user-mode kernel that can be booted."""

    program: str
    version: str
    modules: list[str]
    ip: str
    memory: str
    memory_directory: str

    def __str__(self) -> str:
        return f"{self.program} {self.version}, {self.memory} of memory in {self.memory_directory}"


def find(memory: str) -> Kernel:
    """Find the kernel, its CAN modules, and room for its memory.

    Raises:
        Obstacle: something is missing.
    """
    program = shutil.which("linux.uml")
    if program is None:
        raise Obstacle("linux.uml is not installed: apt-get install user-mode-linux can-utils")
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=False)
    version = done.stdout.strip()
    return Kernel(program, version, find_modules(version), find_ip(), memory, find_room(memory))


def find_modules(version: str) -> list[str]:
    """Find the CAN modules and what they depend on, in the order they load.

    Raises:
        Obstacle: no modules exist for this version of the kernel.
    """
    for root in (Path("/usr/lib/uml/modules", version), Path("/lib/modules", version)):
        with suppress(FileNotFoundError):
            lines = (root / "modules.dep").read_text().splitlines()
            break
    else:
        raise Obstacle(f"no modules of the user-mode kernel {version!r} in /usr/lib/uml/modules")
    depends = {
        Path(file).stem: (file, needs) for file, _, needs in (s.partition(":") for s in lines)
    }
    order: dict[str, None] = {}
    for name in MODULES:
        if name not in depends:
            raise Obstacle(f"{root} has no module {name}")
        file, needs = depends[name]
        order |= dict.fromkeys(str(root / path) for path in (*reversed(needs.split()), file))
    return list(order)


def find_room(memory: str) -> str:
    """Find a directory that can hold the memory: a sparse file that is executed from.

    Raises:
        Obstacle: no directory has room.
    """
    size = int(memory[:-1]) << {"M": 20, "G": 30}[memory[-1]]
    directories = ("/dev/shm", find_shared(), "/var/tmp")
    for directory in filter(os.path.isdir, directories):
        room = os.statvfs(directory)
        executable = not room.f_flag & os.ST_NOEXEC
        if executable and room.f_bavail * room.f_frsize >= size and os.access(directory, os.W_OK):
            return directory
    raise Obstacle(f"no room for {memory} of memory in {' or '.join(directories)}: try --memory 1G")


def find_shared() -> str:
    """Find a directory for temporary files that both kernels see.

    Raises:
        Obstacle: no directory is writable.
    """
    try:
        directory = tempfile.gettempdir()
    except FileNotFoundError as error:
        raise Obstacle(str(error.strerror)) from None
    return "/var/tmp" if hidden_inside(directory) else directory


def hidden_inside(path: str) -> bool:
    """Whether a path means something else inside."""
    return any(Path(path).resolve().is_relative_to(hidden) for hidden in HIDDEN)


def describe_outputs() -> list[tuple[int, int] | None]:
    """Describe standard output and error, each a terminal's rows and columns or None.

    One entry if both are the same file, so that what is written to them stays in order.
    """
    sizes: list[tuple[int, int] | None] = []
    for file in (1, 2):
        size = os.get_terminal_size(file) if os.isatty(file) else None
        sizes.append((size.lines, size.columns) if size else None)
    same = os.path.samestat(os.fstat(1), os.fstat(2))
    return sizes[:1] if same else sizes


def describe_job(kernel: Kernel, command: list[str]) -> Job:
    """Describe the command and what it would find here."""
    umask = os.umask(0)
    os.umask(umask)
    return Job(
        command=command,
        directory=os.getcwd(),
        environment=dict(os.environ),
        user=os.getuid(),
        group=os.getgid(),
        groups=os.getgroups(),
        umask=umask,
        host_name=socket.gethostname(),
        modules=kernel.modules,
        ip=kernel.ip,
        outputs=describe_outputs(),
    )


def boot(kernel: Kernel, directory: str, lines: list[int]) -> "subprocess.Popen[bytes]":
    """Start the kernel as the leader of a session and process group of its own."""
    processor = idlest_processor()
    serial = [f"ssl{number}=null,fd:{line}" for number, line in enumerate(lines)]
    with open(f"{directory}/log", "wb") as log:
        return subprocess.Popen(
            [kernel.program, f"mem={kernel.memory}", "rootfstype=hostfs", "rw", "quiet",
             f"uml_dir={directory}", "con=null", "con0=null,fd:1", "ssl=null", *serial,
             f'init="{sys.executable}"', "--", "-S", "-B", f'"{INIT}"', f'"{directory}"'],
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            env={"PATH": os.defpath, "TMPDIR": kernel.memory_directory},
            pass_fds=lines,
            start_new_session=True,
            # safe, as this process has one thread
            preexec_fn=lambda: os.sched_setaffinity(0, {processor}),  # noqa: PLW1509
        )  # fmt: skip


def run(kernel: Kernel, command: list[str]) -> int:
    """Boot the kernel, run the command inside, leave nothing behind; return its exit code.

    Raises:
        KernelError: the kernel, not the command, failed.
    """
    here = os.getcwd()
    if hidden_inside(here):
        raise KernelError(f"the working directory {here} is not shared with the kernel inside")
    directory = tempfile.mkdtemp(prefix="with-vcan-", dir=find_shared())
    with ending_signals() as signals, guarding(directory) as guard_group:
        job = describe_job(kernel, command)
        Path(directory, "job.json").write_text(json.dumps(job))
        pipes = [os.pipe() for _ in job["outputs"]]
        process = boot(kernel, directory, [write for _, write in pipes])
        guard_group(process.pid)
        for _, write in pipes:
            os.close(write)
        try:
            relay({read: target for (read, _), target in zip(pipes, (1, 2), strict=False)}, signals)
        except Ended as end:
            return 128 + end.signal
        return read_outcome(directory)


def read_outcome(directory: str) -> int:
    """Read how it ended.

    Raises:
        KernelError: not well; with the end of the kernel's log if the kernel said no more.
    """
    try:
        outcome: Outcome = json.loads(Path(directory, "outcome.json").read_text())
    except FileNotFoundError:
        log = Path(directory, "log").read_text(errors="replace")
        panic = re.search("Kernel panic.*", log)
        words = panic[0] if panic else " ".join(log.split())[-400:] or "none"
        raise KernelError(f"the user-mode kernel died; its last words: {words}") from None
    if "error" in outcome:
        raise KernelError(f"inside the user-mode kernel: {outcome['error']}")
    return outcome["exit_code"]
