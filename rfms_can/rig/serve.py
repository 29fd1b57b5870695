"""A server: brings a rig up, enables the arm and serves coordinators until it is interrupted.

One thread: the sockets are polled between two steps of the bus. In real time that is after every
frame, so that a request received before a cycle is closed acts on the set-point made then.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final, NamedTuple

from rfms_can.errors import FaultError, LinkError
from rfms_can.link.address import DEFAULT_NAME, TcpAddress, rendezvous_of
from rfms_can.link.keys import ServerKeys
from rfms_can.link.server import ServerSocket, check_binding
from rfms_can.master.server.core import NO_GRANTS, Server
from rfms_can.messages import ServerNumbers
from rfms_can.rig.record import Record
from rfms_can.rig.result import RunResult
from rfms_can.rig.runner import checked_bus_bound, complete_record, make_rig
from rfms_can.rig.server_driver import ServerDriver
from rfms_can.rig.session import HALT_CYCLES, Rig, Session
from rfms_can.rig.settings import RunSettings

LOOK_S: Final = 0.1
"""Period at which the lease is checked and the state broadcast while time stands still, s."""
THINKING_FRACTION: Final = 0.25
"""Fraction of the lockstep barrier for which cycles wait for a coordinator that computes."""
ENDING: Final = "the server is ending: it takes no more requests"


class Listening(NamedTuple):
    """Where a server listens.

    Attributes:
        name: of its Unix sockets.
        tcp: additional TCP address, or None.
        keys: CURVE keys of the TCP connections, or None.
    """

    name: str = DEFAULT_NAME
    tcp: TcpAddress | None = None
    keys: ServerKeys | None = None


class Served(NamedTuple):
    """Result of a server's run.

    Attributes:
        result: the run's numbers.
        numbers: of the server.
        fault: the latched fault that halted it, or None.
    """

    result: RunResult
    numbers: ServerNumbers
    fault: FaultError | None


class Serving:
    """Serves a rig to coordinators.

    Args:
        rig: the nodes and their bus.
        socket: the sockets; the caller closes them.
        interrupted: whether the server is to end.
        shown: called now and then, and at least every ``LOOK_S``.
        bus_bound, keep: as with ``Session``.
        grants: references by the sensor that may observe them.

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
        grants: Mapping[str, Sequence[str]] = NO_GRANTS,
    ) -> None:
        master = self._master = rig.master
        self._clock = master.settings.clock_definition
        self._barrier_s = master.settings.barrier_s
        self._interrupted = interrupted
        self._shown = shown
        self._waited_long_enough = False
        self.server = Server(master, grants)
        self._driver = ServerDriver(self.server, socket)
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
        """Serve until ``interrupted`` returns True, also after a fault; then the arm is braked.

        Args:
            ready: called when the arm is enabled.

        Raises:
            FaultError: the arm could not be brought up, or was halted by a fault at the end.
        """
        session = self.session
        try:
            session.bring_up()
            ready()
            self._serve()
            self._driver.end(ENDING)
            if self._master.fault is not None:
                raise FaultError(self._master.fault)
            session.stop_moving()
        except KeyboardInterrupt:  # while the bus came up
            self._driver.end(ENDING)
        except FaultError:
            session.coast(HALT_CYCLES)
            raise
        finally:
            session.disable()
            self._driver.wait(0.0)
            self._driver.broadcast()

    def _serve(self) -> None:
        master, link = self._master, self.session.link
        while not self._interrupted():
            if self._may_go_on():
                master.timer.pace(not self.server.time_may_pass)
                link.pass_time(
                    lambda: self._interrupted() or not self._may_go_on(), self._after_event
                )
            else:
                self._stand_still()

    def _may_go_on(self) -> bool:
        """Whether the next cycle may begin; in lockstep the nodes' waiting time is bounded."""
        if self._master.timer.stopped:  # the nodes did not come back: there is no next cycle
            return False
        if self.server.time_may_pass:
            self._waited_long_enough = False
            return True
        enough = self._waited_long_enough or self.server.holder is None
        return enough and self._clock.waits_for_nodes

    def _after_event(self) -> bool:
        """Poll the sockets between two steps of the bus; whether the server is to end."""
        if not self._clock.in_one_process:
            self._driver.serve()
            if self._clock.waits_for_nodes:
                self._master.timer.pace(not self.server.time_may_pass)
        return self._interrupted()

    def _close_cycle(self) -> None:
        self._driver.serve()
        self._driver.close_cycle()

    def _stand_still(self) -> None:
        """Wait until a client lets time pass; in lockstep at most the fraction of the barrier."""
        limit_s = self._barrier_s * THINKING_FRACTION
        waiting = self._clock.waits_for_nodes and not self._master.timer.stopped
        until = time.monotonic() + limit_s
        while not self._interrupted() and not self._may_go_on():
            left_s = until - time.monotonic() if waiting else LOOK_S
            self._waited_long_enough = left_s <= 0.0
            self._driver.wait(max(0.0, min(left_s, LOOK_S)))
            self._driver.broadcast()
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
    grants: Mapping[str, Sequence[str]] = NO_GRANTS,
) -> Served:
    """Serve a rig built from the settings; see ``execute`` and ``Serving`` for the arguments.

    Raises:
        LinkError: the name or a port is taken, or must not be bound.
        RfmsError: the bus could not be brought up.
    """
    check_binding(listening.tcp, listening.keys)
    if rendezvous_of(listening.name).alive:
        raise LinkError(f"server {listening.name!r} is running already: take another --name")
    run_record = None if record is None else Record(record)
    rig, log = make_rig(settings, run_record, attach)
    try:
        watch(rig)
        with ServerSocket(*listening) as socket:  # after the rig has forked its processes
            serving = Serving(
                rig,
                socket,
                interrupted=interrupted,
                shown=shown,
                bus_bound=checked_bus_bound(settings),
                keep=run_record is not None,
                grants=grants,
            )
            fault: FaultError | None = None
            try:
                serving.run(ready)
            except FaultError as error:
                fault = error
            finally:
                complete_record(serving.session, settings, run_record, log)
            return Served(serving.session.result(), serving.server.numbers(), fault)
    finally:
        rig.close()
        if log is not None:
            log.close()
