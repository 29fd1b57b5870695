"""The driver loop of one node on a port: everything readable first, then the timer."""

import time
from collections.abc import Callable
from typing import Final

from rfms_can.bus.port import LONGEST_WAIT_S, Port, counts_of
from rfms_can.node.port_counts import tell_port
from rfms_can.node.protocol import Node

MAX_FRAMES_BEFORE_TIMER: Final = 256
"""A babbling idiot on the bus must not delay a node's deadlines."""

FAR_NS: Final = 200_000_000
"""A deadline this far ahead cannot end the current wait (at most ``LONGEST_WAIT_S``), ns."""

CLOCK_EVERY: Final = 16
"""Frames after which the clock is read in any case."""

Clock = Callable[[], int]
"""Monotonic time, ns."""


class NodeDriver:
    """Moves one node's frames and re-arms its timer.

    The clock is read before a wait that a deadline may end, whenever nothing came, and at least
    once in ``CLOCK_EVERY`` frames. While deadlines are far (lockstep) that makes one system call
    a frame; near them every wait is exact.

    Args:
        node: the node.
        port: of the node; the caller closes it.
        clock: monotonic time, ns.
    """

    __slots__ = ("_clock", "_frames", "_node", "_now_ns", "_port")

    def __init__(self, node: Node, port: Port, clock: Clock = time.monotonic_ns) -> None:
        self._node = node
        self._port = port
        self._clock = clock
        self._now_ns = clock()
        self._frames = 0
        tell_port(node, lambda: counts_of(port.statistics))

    def pump(self) -> None:
        """Wait for the next frame or deadline, at most ``LONGEST_WAIT_S``, and handle it.

        Raises:
            BusError: the bus has gone.
        """
        deadline_ns = self._node.next_deadline_ns()
        if deadline_ns is None:  # the next frame may set one, relative to its arrival
            self._take_frame(LONGEST_WAIT_S, timed=True)
            return
        self._frames -= 1
        if self._frames < 0 or deadline_ns - self._now_ns < FAR_NS:
            self._read_clock()
            wait_ns = deadline_ns - self._now_ns
            if wait_ns <= 0:
                self._serve_deadline()
                return
            if wait_ns < FAR_NS:
                self._take_frame(wait_ns * 1e-9, timed=True)
                return
        if not self._take_frame(LONGEST_WAIT_S):
            self._read_clock()

    def _read_clock(self) -> None:
        self._now_ns = self._clock()
        self._frames = CLOCK_EVERY

    def run_until(self, goal: Callable[[], bool]) -> None:
        """Pump until a predicate holds; it is evaluated before each step."""
        while not goal():
            self.pump()

    def _take_frame(self, timeout_s: float, *, timed: bool = False) -> bool:
        """Handle the next frame; ``timed``: read the clock at its arrival."""
        frame = self._port.recv(timeout_s)
        if frame is None:
            return False
        if timed:
            self._read_clock()
        answers = self._node.on_frame(frame, self._now_ns)
        if answers:
            self._port.send(answers)
        return True

    def _serve_deadline(self) -> None:
        """Handle a deadline that has passed, after the frames that arrived before it."""
        for _ in range(MAX_FRAMES_BEFORE_TIMER):
            if not self._take_frame(0.0, timed=True):
                break
        deadline_ns = self._node.next_deadline_ns()
        self._read_clock()
        if deadline_ns is not None and deadline_ns <= self._now_ns:
            frames = self._node.on_time(self._now_ns)
            if frames:
                self._port.send(frames)


def run_node(
    node: Node,
    port: Port,
    clock: Clock = time.monotonic_ns,
    stop: Callable[[], bool] = lambda: False,
) -> None:
    """Drive a node until ``stop`` returns True.

    Raises:
        BusError: the bus has gone.
    """
    NodeDriver(node, port, clock).run_until(stop)
