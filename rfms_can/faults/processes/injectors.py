"""Every fault of processes by its name: whom it strikes, how, and when it begins to show."""

import resource
import signal
import subprocess
import time
from collections.abc import Callable
from enum import Enum
from random import Random
from typing import Final, NamedTuple

from rfms_can.errors import RfmsError
from rfms_can.faults.processes.command import SEAM_SIGNAL, children_of
from rfms_can.faults.processes.seams import LARGEST_JUMP_S, NO_BUFFER, sends_fail, wall_clock_jumps
from rfms_can.faults.processes.system import System
from rfms_can.wire.nodes import MASTER, PLANT

JOINT: Final = 0
"""Of an injector: the joint that is drawn."""
WAKES_AFTER: Final = 20
"""Cycles after which a process that was stopped goes on."""
REJOINS_AFTER: Final = 10
SETTLE_S: Final = 0.2
"""How long a bus is left alone that was set down."""


class Shows(Enum):
    """From when on a fault can be seen; the value is told in the documentation."""

    SILENCE = "with the first cycle that lacks a frame of the node"
    INTRUSION = "with the first frame of the intruder"
    AT_ONCE = "when it is put in"


class ProcessInjector(NamedTuple):
    """A fault of processes.

    Attributes:
        node: number of the node at fault; ``JOINT`` where it is any joint.
        does: what is wrong then, for documentation.
        make: does it.
        shows: from when on.
        seam: makes what ``SEAM_SIGNAL`` does in the processes of the system, of the trial's random
            numbers and of whether the bus is a hub.
        recorded: whether the run is recorded.
    """

    node: int
    does: str
    make: Callable[[System], None]
    shows: Shows = Shows.SILENCE
    seam: Callable[[Random, bool], Callable[[], None]] | None = None
    recorded: bool = False


def _at(system: System, node: int) -> int:
    return node or system.joint


def _killed(node: int) -> Callable[[System], None]:
    return lambda system: system.signal(_at(system, node), signal.SIGKILL)


def _paused(node: int) -> Callable[[System], None]:
    def make(system: System) -> None:
        system.signal(_at(system, node), signal.SIGSTOP)
        system.wait_cycles(WAKES_AFTER)
        system.comes_back()
        system.signal(_at(system, node), signal.SIGCONT)

    return make


def _starts_again(system: System) -> None:
    system.signal(system.joint, signal.SIGKILL)
    system.wait_cycles(REJOINS_AFTER)
    system.comes_back()
    system.start("joint", str(system.joint))


def _second_joint(system: System) -> None:
    system.start("joint", str(system.joint))


def _second_master(system: System) -> None:
    system.start("master", "--arm", system.arm)


def _no_room(system: System) -> None:
    system.signal(system.joint, SEAM_SIGNAL)


def _disk_full(system: System) -> None:
    """No file of the run may grow beyond what its log has now (RLIMIT_FSIZE)."""
    master = system.pid(MASTER)
    limit = max(1, system.log.stat().st_size)
    for pid in (master, *children_of(master)):
        resource.prlimit(pid, resource.RLIMIT_FSIZE, (limit, limit))


def _bus_goes(system: System) -> None:
    """The hub is killed; a CAN interface is set down, and up again once all have noticed."""
    if system.hub is not None:
        system.hub.signal(signal.SIGKILL)
        return
    _link(system.interface, "down")
    time.sleep(SETTLE_S)
    _link(system.interface, "up")


def _link(interface: str, word: str) -> None:
    command = ["ip", "link", "set", interface, word]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RfmsError(
            f"{' '.join(command)}: {done.stderr.strip() or done.returncode}; it needs root, as in "
            f"tools/with-vcan"
        )


PROCESS_INJECTORS: Final[dict[str, ProcessInjector]] = {
    "kill_joint": ProcessInjector(JOINT, "the process of a joint is killed", _killed(JOINT)),
    "kill_master": ProcessInjector(MASTER, "the master is killed", _killed(MASTER)),
    "kill_plant": ProcessInjector(PLANT, "the plant is killed", _killed(PLANT)),
    "pause_joint": ProcessInjector(
        JOINT, "the process of a joint is stopped for 20 cycles", _paused(JOINT)
    ),
    "pause_master": ProcessInjector(MASTER, "the master is stopped for 20 cycles", _paused(MASTER)),
    "restart_process": ProcessInjector(
        JOINT, "the process of a joint is killed, and started again", _starts_again
    ),
    "no_room_to_send": ProcessInjector(
        JOINT,
        "the kernel takes no frame of a joint any more (ENOBUFS; EAGAIN on a hub)",
        _no_room,
        seam=lambda _, on_hub: sends_fail(NO_BUFFER[on_hub]),
    ),
    "cut_bus": ProcessInjector(
        MASTER, "the hub is killed, the interface is set down", _bus_goes, Shows.AT_ONCE
    ),
    "wall_clock": ProcessInjector(
        MASTER,
        "the time of day jumps by up to 400 days in all processes",
        System.signal_all,
        Shows.AT_ONCE,
        seam=lambda draw, _: wall_clock_jumps(draw.uniform(-1.0, 1.0) * LARGEST_JUMP_S),
    ),
    "start_master": ProcessInjector(
        MASTER, "a second rfms master is started", _second_master, Shows.INTRUSION
    ),
    "start_joint": ProcessInjector(
        JOINT, "a second rfms joint of the same number is started", _second_joint, Shows.INTRUSION
    ),
    "full_disk": ProcessInjector(
        MASTER,
        "no file of the run can grow any more",
        _disk_full,
        Shows.AT_ONCE,
        recorded=True,
    ),
}
"""By name."""
