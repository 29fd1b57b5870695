"""``vcan0`` on the kernel this machine runs: used if it is up, set up if that is possible."""

import os
import shutil
import socket
import subprocess
from pathlib import Path

from . import Obstacle

INTERFACE = Path("/sys/class/net/vcan0")
FD_MTU = 72
"""``sizeof(struct canfd_frame)``: an interface with a smaller MTU carries classic CAN only."""
IFF_UP = 0x1


def set_up() -> None:
    """Bring ``vcan0`` up with the MTU of CAN FD, through sudo if need be.

    Raises:
        Obstacle: this kernel has no CAN, or the interface cannot be set up without permission.
    """
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError as error:
        raise Obstacle(f"this kernel has no CAN: {error.strerror}") from None
    if not INTERFACE.exists():
        ip("link", "add", "dev", INTERFACE.name, "type", "vcan")
    if not int((INTERFACE / "flags").read_text(), 16) & IFF_UP:
        ip("link", "set", INTERFACE.name, "mtu", str(FD_MTU), "up")
    mtu = int((INTERFACE / "mtu").read_text())
    if mtu < FD_MTU:
        raise Obstacle(f"vcan0 is up with MTU {mtu}, CAN FD needs {FD_MTU}; take it down first")


def find_ip() -> str:
    """Find ip(8), which ordinary users often have outside their path.

    Raises:
        Obstacle: it is not installed.
    """
    program = shutil.which("ip", path=f"{os.environ.get('PATH', os.defpath)}:/usr/sbin:/sbin")
    if program is None:
        raise Obstacle("ip is not installed: apt-get install iproute2")
    return program


def ip(*arguments: str) -> None:
    """Run ip(8) as root.

    Raises:
        Obstacle: it failed, or sudo would ask for a password.
    """
    command = [find_ip(), *arguments]
    if os.geteuid() != 0:
        command = ["sudo", "--non-interactive", *command]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise Obstacle(f"{command[0]}: {error.strerror}") from None
    if done.returncode:
        reason = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1]
        raise Obstacle(f"{' '.join(command)}: {reason}")
