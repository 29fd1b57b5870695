"""The driver loop of one node on a port: everything readable first, then the timer."""

import time
from collections.abc import Callable
from typing import Final

from rfms_can.bus.port import LONGEST_WAIT_S, Port
from rfms_can.node import Node

MAX_FRAMES_BEFORE_TIMER: Final = 256
"""A bus that babbles without end must not keep a node from its deadlines."""

Clock = Callable[[], int]
"""Monotonic time, ns."""


class NodeDriver:
    """Moves one node's frames and re-arms its timer.

    Args:
        node: the node.
        port: its way onto the bus; the caller closes it.
        clock: monotonic time, ns.
    """

    __slots__ = ("_clock", "_node", "_port")

    def __init__(self, node: Node, port: Port, clock: Clock = time.monotonic_ns) -> None:
        self._node = node
        self._port = port
        self._clock = clock

    def pump(self) -> None:
        """Wait for the next frame or deadline, at most ``LONGEST_WAIT_S``, and serve it.

        Raises:
            BusError: the bus has gone.
        """
        deadline_ns = self._node.next_deadline_ns()
        if deadline_ns is None:
            self._take_frame(LONGEST_WAIT_S)
            return
        wait_ns = deadline_ns - self._clock()
        if wait_ns > 0:
            self._take_frame(wait_ns * 1e-9)
        else:
            self._serve_deadline()

    def run_until(self, goal: Callable[[], bool]) -> None:
        """Pump until a predicate holds; it is asked before each step."""
        while not goal():
            self.pump()

    def _take_frame(self, timeout_s: float) -> bool:
        frame = self._port.recv(timeout_s)
        if frame is None:
            return False
        answers = self._node.on_frame(frame, self._clock())
        if answers:
            self._port.send(answers)
        return True

    def _serve_deadline(self) -> None:
        """A deadline has come: what arrived before it was looked at comes first."""
        for _ in range(MAX_FRAMES_BEFORE_TIMER):
            if not self._take_frame(0.0):
                break
        deadline_ns = self._node.next_deadline_ns()
        now_ns = self._clock()
        if deadline_ns is not None and deadline_ns <= now_ns:
            frames = self._node.on_time(now_ns)
            if frames:
                self._port.send(frames)


def run_node(
    node: Node,
    port: Port,
    clock: Clock = time.monotonic_ns,
    stop: Callable[[], bool] = lambda: False,
) -> None:
    """Drive a node until ``stop`` says so.

    Raises:
        BusError: the bus has gone.
    """
    NodeDriver(node, port, clock).run_until(stop)
