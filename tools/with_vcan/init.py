"""Process 1 of the user-mode kernel: mount, set ``vcan0`` up, run the command, switch off.

Runs inside the kernel as ``python init.py DIRECTORY``: ``job.json`` there says what to run, and
``outcome.json`` what came of it. Its own errors go to the console, which is the kernel's log.
"""

import ctypes
import fcntl
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import termios
import threading
import tty
from pathlib import Path
from typing import TypedDict

MOUNTS = (
    ("proc", "/proc", None),
    ("sysfs", "/sys", None),
    ("tmpfs", "/run", b"mode=755"),
    ("tmpfs", "/dev/shm", b"mode=1777"),
    ("devpts", "/dev/pts", b"mode=620,ptmxmode=666"),
)
LINKS = {"fd": "fd", "stdin": "fd/0", "stdout": "fd/1", "stderr": "fd/2"}
SYS_FINIT_MODULE = {"x86_64": 313, "i686": 350}
RB_POWER_OFF = 0x4321FEDC

libc = ctypes.CDLL(None, use_errno=True)


class Job(TypedDict):
    """What the command needs to find inside what it would have found outside."""

    command: list[str]
    directory: str
    environment: dict[str, str]
    user: int
    group: int
    groups: list[int]
    umask: int
    host_name: str
    modules: list[str]  # files, in the order they load
    ip: str
    outputs: list[tuple[int, int] | None]  # per serial line: a terminal's rows and columns, or none


class Outcome(TypedDict, total=False):
    """How it ended: one of the two."""

    exit_code: int
    error: str


def check(result: int, what: str) -> None:
    """Turn a failed call of the C library into an exception that says what failed."""
    if result != 0:
        raise OSError(ctypes.get_errno(), f"{what}: {os.strerror(ctypes.get_errno())}")


def mount_file_systems() -> None:
    """Mount what belongs to this kernel, and make the links in ``/dev`` that shells rely on."""
    for kind, target, data in MOUNTS:
        os.makedirs(target, exist_ok=True)
        check(libc.mount(kind.encode(), target.encode(), kind.encode(), 0, data), f"mount {target}")
    for name, target in LINKS.items():
        os.symlink(f"/proc/self/{target}", f"/dev/{name}")


def set_up_network(job: Job) -> None:
    """Load CAN, and bring the loopback and ``vcan0`` (CAN FD) up."""
    for path in job["modules"]:
        file = os.open(path, os.O_RDONLY)
        check(libc.syscall(SYS_FINIT_MODULE[os.uname().machine], file, b"", 0), path)
        os.close(file)
    commands = "link set lo up\nlink add dev vcan0 mtu 72 type vcan\nlink set vcan0 up\n"
    subprocess.run([job["ip"], "-batch", "-"], input=commands, text=True, check=True)
    socket.sethostname(job["host_name"])


def open_line(number: int, terminal: tuple[int, int] | None) -> int:
    """Open a serial line to the outside, as a plain path for bytes."""
    line = os.open(f"/dev/ttyS{number}", os.O_RDWR | os.O_NOCTTY)
    tty.setraw(line)
    if terminal:
        fcntl.ioctl(line, termios.TIOCSWINSZ, struct.pack("4H", *terminal, 0, 0))
    return line


def copy(source: int, line: int) -> None:
    """Copy a pipe to a serial line until the other end is closed."""
    while data := os.read(source, 65536):
        while data:
            data = data[os.write(line, data) :]


class Output:
    """One output of the command: a terminal if it is one outside, a pipe otherwise."""

    def __init__(self, number: int, terminal: tuple[int, int] | None, owner: int) -> None:
        self.line = self.end = open_line(number, terminal)
        self.copier: threading.Thread | None = None
        if not terminal:
            source, self.end = os.pipe()
            self.copier = threading.Thread(target=copy, args=(source, self.line))
            self.copier.start()
        os.fchown(self.end, owner, -1)  # so that the command may open /dev/stdout

    def finish(self) -> None:
        """Wait until every byte is outside."""
        if self.copier:
            os.close(self.end)
            self.copier.join()
        termios.tcdrain(self.line)


def run_command(job: Job) -> int:
    """Run the command; return its exit code as a shell gives it."""
    outputs = [Output(n, size, job["user"]) for n, size in enumerate(job["outputs"])]
    identity = {"user": job["user"], "group": job["group"], "extra_groups": job["groups"]}
    try:
        process = subprocess.Popen(
            job["command"],
            cwd=job["directory"],
            env=job["environment"],
            umask=job["umask"],
            stdin=subprocess.DEVNULL,
            stdout=outputs[0].end,
            stderr=outputs[-1].end,
            **identity,  # type: ignore[call-overload]
        )
    except OSError as error:
        name = f"with-vcan: {error.filename or job['command'][0]}: {error.strerror}\n"
        os.write(outputs[-1].end, name.encode())
        code = 127 if isinstance(error, FileNotFoundError) else 126
    else:
        code = wait_as_process_1(process.pid)
    for output in outputs:
        output.finish()
    return code


def wait_as_process_1(command: int) -> int:
    """Reap whatever ends until the command does; then end what it left running."""
    while True:
        process, status = os.wait()
        if process == command:
            break
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    os.kill(-1, signal.SIGKILL)
    code = os.waitstatus_to_exitcode(status)
    return code if code >= 0 else 128 - code


def main(directory: Path) -> None:
    """Do the job in this directory and switch the kernel off."""
    outcome = Outcome()
    try:
        job: Job = json.loads((directory / "job.json").read_text())
        mount_file_systems()
        set_up_network(job)
        outcome["exit_code"] = run_command(job)
    except Exception as error:  # process 1 must not end: it reports, and switches off
        outcome["error"] = f"{type(error).__name__}: {error}"
    finally:
        (directory / "outcome.json").write_text(json.dumps(outcome))
        os.sync()  # files are written back to the host here
        libc.reboot(RB_POWER_OFF)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
