"""A server: brings a rig up, enables the arm and serves coordinators until it is told to end.

One thread: the sockets are looked at between two steps of the bus. In real time that is after
every frame, so that what has come before a cycle is closed acts in the set-point made then.
"""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple

from rfms_can.errors import FaultError, LinkError
from rfms_can.link.address import DEFAULT_NAME, TcpAddress, place_of
from rfms_can.link.keys import ServerKeys
from rfms_can.link.server import ServerSocket, check_binding
from rfms_can.master.server.core import Server
from rfms_can.master.settings import CLOCKS
from rfms_can.messages import ServerNumbers
from rfms_can.rig.desk import Desk
from rfms_can.rig.record import Record
from rfms_can.rig.result import RunResult
from rfms_can.rig.runner import affordable, make_rig, write_down
from rfms_can.rig.session import HALT_CYCLES, Rig, Session
from rfms_can.rig.settings import RunSettings

LOOK_S: Final = 0.1
"""While time stands still the lease is looked at, and the state broadcast, this often."""
THINKING_PART: Final = 0.25
"""Part of the lockstep barrier for which cycles wait for a coordinator that does not wait."""
ENDING: Final = "the server is ending: it takes no more requests"


class Listening(NamedTuple):
    """Where a server listens.

    Attributes:
        name: of its Unix sockets.
        tcp: TCP address besides, or None.
        keys: CURVE keys of the TCP connections, or None.
    """

    name: str = DEFAULT_NAME
    tcp: TcpAddress | None = None
    keys: ServerKeys | None = None


class Served(NamedTuple):
    """How serving ended.

    Attributes:
        result: the run's numbers.
        numbers: the server's.
        fault: the latched fault that halted it, or None.
    """

    result: RunResult
    numbers: ServerNumbers
    fault: FaultError | None


class Serving:
    """A rig that is being served.

    Args:
        rig: the nodes and their bus.
        socket: the sockets; the caller closes them.
        interrupted: whether the server shall end.
        shown: called now and then, and at least every ``LOOK_S``.
        bus_bound, keep: as with ``Session``.

    Attributes:
        server: the core.
        session: the run.
    """

    def __init__(
        self,
        rig: Rig,
        socket: ServerSocket,
        *,
        interrupted: Callable[[], bool] = lambda: False,
        shown: "Callable[[Serving], None] | None" = None,
        bus_bound: float | None = None,
        keep: bool = False,
    ) -> None:
        master = self._master = rig.master
        self._clock = CLOCKS[master.settings.clock]
        self._barrier_s = master.settings.barrier_s
        self._interrupted = interrupted
        self._shown = shown
        self._thought_long = False
        self.server = Server(master)
        self._desk = Desk(self.server, socket)
        self.session = Session(
            rig,
            bus_bound=bus_bound,
            progress=lambda _: self._show(),
            keep=keep,
            each_cycle=self._close_cycle,
            threaded=False,
            interrupted=self._after_event,
        )

    def run(self, ready: Callable[[], None] = lambda: None) -> None:
        """Serve until ``interrupted``; the arm is braked then.

        Args:
            ready: called when the arm is enabled.

        Raises:
            FaultError: a latched fault halted the run; everybody has been told.
        """
        session = self.session
        try:
            session.bring_up()
            ready()
            self._serve()
            self._desk.end(ENDING)
            session.stop_moving()
        except KeyboardInterrupt:  # while the bus came up
            self._desk.end(ENDING)
        except FaultError:
            session.coast(HALT_CYCLES)
            raise
        finally:
            session.disable()
            self._desk.wait(0.0)
            self._desk.broadcast()

    def _serve(self) -> None:
        master, link = self._master, self.session.link
        while not self._over():
            if self._may_go_on():
                master.timer.paced = not self.server.time_may_pass
                link.pass_time(lambda: self._over() or not self._may_go_on(), self._after_event)
            else:
                self._stand_still()
        if master.fault is not None:
            raise FaultError(master.fault)

    def _over(self) -> bool:
        return self._master.fault is not None or self._interrupted()

    def _may_go_on(self) -> bool:
        """Whether the next cycle may begin; in lockstep nodes are not kept waiting for long."""
        if self.server.time_may_pass:
            self._thought_long = False
            return True
        enough = self._thought_long or self.server.holder is None
        return enough and self._clock.waits_for_nodes

    def _after_event(self) -> bool:
        """Look at the sockets between two steps of the bus; whether the server shall end."""
        if not self._clock.in_one_process:
            self._desk.serve()
            if self._clock.waits_for_nodes:
                self._master.timer.paced = not self.server.time_may_pass
        return self._interrupted()

    def _close_cycle(self) -> None:
        self._desk.serve()
        self._desk.close_cycle()

    def _stand_still(self) -> None:
        """No cycle until somebody lets time pass, or in lockstep until nodes have waited enough."""
        limit_s = self._barrier_s * THINKING_PART
        waiting = self._clock.waits_for_nodes
        until = time.monotonic() + limit_s
        while not self._over() and not self._may_go_on():
            left_s = until - time.monotonic() if waiting else LOOK_S
            self._thought_long = left_s <= 0.0
            self._desk.wait(max(0.0, min(left_s, LOOK_S)))
            self._desk.broadcast()
            self._show()

    def _show(self) -> None:
        if self._shown is not None:
            self._shown(self)


def serve(
    settings: RunSettings,
    listening: Listening,
    *,
    record: Path | None = None,
    attach: bool = False,
    watch: Callable[[Rig], None] = lambda _: None,
    ready: Callable[[], None] = lambda: None,
    shown: Callable[[Serving], None] | None = None,
    interrupted: Callable[[], bool] = lambda: False,
) -> Served:
    """Serve a rig made of the settings; the arguments are those of ``execute`` and ``Serving``.

    Raises:
        LinkError: the name or a port is taken, or must not be bound.
        RfmsError: the bus could not be brought up.
    """
    check_binding(listening.tcp, listening.keys)
    if place_of(listening.name).alive:
        raise LinkError(f"server {listening.name!r} is running already: take another --name")
    keeper = None if record is None else Record(record)
    rig, writer = make_rig(settings, keeper, attach)
    try:
        watch(rig)
        with ServerSocket(*listening) as socket:  # after the rig has forked its processes
            serving = Serving(
                rig,
                socket,
                interrupted=interrupted,
                shown=shown,
                bus_bound=affordable(settings),
                keep=keeper is not None,
            )
            fault: FaultError | None = None
            try:
                serving.run(ready)
            except FaultError as error:
                fault = error
            finally:
                write_down(serving.session, settings, keeper)
            return Served(serving.session.result(), serving.server.numbers(), fault)
    finally:
        rig.close()
        if writer is not None:
            writer.close()
