"""The program of a sensor: observes references of a server's arm, in a process of its own.

::

    with connect_sensor("rfms", name="camera") as camera:
        while True:
            camera.sleep(0.02)
            camera.observe("part", picture(), at=camera.time - 0.02)

It needs a grant: of the coordinator (``arm.grant("camera", ["part"])``) or of the server
(``rfms serve --grant camera=part``). It moves nothing else.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final

from rfms_can.coordinator import definitions
from rfms_can.coordinator.conversation import Lease
from rfms_can.coordinator.equation import Expression
from rfms_can.coordinator.link import Link
from rfms_can.coordinator.program_link import ProgramLink
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.coordinator.sockets import Socket
from rfms_can.coordinator.validation import checked
from rfms_can.coordinator.view import cycle_after
from rfms_can.errors import LeaseError, ProgramError
from rfms_can.link.address import DEFAULT_NAME
from rfms_can.link.client import ClientSocket
from rfms_can.link.keys import ClientKeys
from rfms_can.messages import SensorRequest, Status
from rfms_can.messages.world import Predict
from rfms_can.transform import Transform

ALIVE_S: Final = 0.5
"""Time without a message after which the server takes a sensor as silent, s."""
RETRY_S: Final = 0.1
"""Time between two attempts to connect while there is no grant, s."""
LONGEST_PATIENCE_S: Final = 3600.0


class Attachment(Lease):
    """A sensor's place at a server, kept like a lease: requests to take, renew and leave it."""

    __slots__ = ()

    @property
    def acquire(self) -> SensorRequest:
        """Take it."""
        return SensorRequest("attach", self.name, self.duration_s)

    @property
    def renew(self) -> SensorRequest:
        """Say that the sensor is there."""
        return SensorRequest("renew", self.name, self.duration_s)

    @property
    def release(self) -> SensorRequest:
        """Leave it."""
        return SensorRequest("detach", self.name)


class Sensor:
    """A sensor's view of the server.

    Attributes:
        name: it connects with.
    """

    def __init__(self, link: Link, name: str, renew: Callable[[], object]) -> None:
        self.name = name
        self._link = link
        self._renew = renew

    @property
    def status(self) -> Status:
        """The arm's state at the last closed cycle that is known here."""
        return self._link.status()

    @property
    def time(self) -> float:
        """The server's time, s, for time stamps of observations; see ``Arm.time``."""
        return self._link.time()

    def observe(
        self,
        reference: str | Expression,
        value: Transform,
        at: float | None = None,
        twist: Sequence[float] | None = None,
        *,
        predict: Predict | None = None,
        rest_after: float | None = None,
    ) -> None:
        """Send an observation of a reference; defines it if the coordinator has not.

        Args:
            reference: its name.
            value: observed value.
            at: the server's time of the observation, s; None: now.
            twist: velocity of its origin, m/s, and its angular velocity, rad/s, in the frame the
                value is given in (6); estimated from the observations if not given.
            predict, rest_after: as with ``Arm.reference``; None: as the reference was defined.

        Raises:
            TransformError: not a transform, or refused by the server.
            LeaseError: no grant for it, or no coordinator controls the arm.
        """
        message = definitions.sighting(
            str(reference), value, at, twist, predict=predict, rest_after=rest_after
        )
        self._link.request(message)

    def sleep(self, seconds: float) -> None:
        """Wait for a time on the arm's clock, in whole control periods.

        Raises:
            ProgramError: the time is negative or not a number.
            LeaseError: the grant has ended.
        """
        self._link.wait(cycle_after(self._link.status(), seconds))

    def wait_for_coordinator(self, within: float = 10.0) -> None:
        """Wait, in wall time, until a coordinator controls the arm: before, nothing is observed.

        Raises:
            LeaseError: none does in time.
            ProgramError: the time is out of bounds.
        """
        until = time.monotonic() + _patience(self.name, within)
        while self.status.lease is None:
            if time.monotonic() >= until:
                raise LeaseError(
                    f"sensor {self.name!r}: no coordinator controls the arm after {within:g} s: "
                    f"start its program, or wait longer"
                )
            time.sleep(RETRY_S)
            self._renew()


@contextmanager
def connect_sensor(
    server: str = DEFAULT_NAME,
    *,
    name: str,
    keys: ClientKeys | None = None,
    alive_s: float = ALIVE_S,
    patience_s: float = 10.0,
    interrupted: Callable[[], bool] = lambda: False,
) -> Iterator[Sensor]:
    """Be a sensor of a server's arm within the block.

    Args:
        server: its NAME, or ``tcp://ADDRESS:PORT``.
        name: of the sensor, as it is granted.
        keys: CURVE keys, for a server that requires them.
        alive_s: time without a message after which the server takes it as silent, 0.1 to 10 s.
        patience_s: how long to wait for a grant, or for the name, s.
        interrupted: whether the program is to end; called while it waits.

    Raises:
        LinkError: no server is running, or it does not answer.
        LeaseError: there is no grant, or another session is this sensor.
        ProgramError: a time is out of bounds.
    """
    _patience(name, patience_s)
    with ClientSocket(server, keys) as socket:
        link = sensor_link(socket, name, alive_s, interrupted)
        _attach(link, time.monotonic() + patience_s, interrupted)
        try:
            with ProgramLink(link, interrupted=interrupted) as program:
                yield Sensor(program, name, link.renew)
        finally:
            link.release()


def sensor_link(
    socket: Socket, name: str, alive_s: float, interrupted: Callable[[], bool] = lambda: False
) -> RemoteLink:
    """The link of a sensor.

    Raises:
        ProgramError: the name or the time is out of bounds.
    """
    place = Attachment(name, alive_s)
    checked(place.acquire, ProgramError, f"sensor {name!r}")
    return RemoteLink(socket, name, alive_s, lease=place, interrupted=interrupted)


def _patience(name: str, seconds: float) -> float:
    if not isinstance(seconds, float | int) or not 0.0 <= seconds <= LONGEST_PATIENCE_S:
        raise ProgramError(
            f"sensor {name!r} is to wait for {seconds!r} s: give a time, 0 to "
            f"{LONGEST_PATIENCE_S:g}"
        )
    return seconds


def _attach(link: RemoteLink, until: float, interrupted: Callable[[], bool]) -> None:
    """Take the sensor's place, when there is a grant."""
    while True:
        try:
            link.acquire()
        except LeaseError:
            if time.monotonic() >= until:
                raise
            if interrupted():
                raise KeyboardInterrupt from None
            time.sleep(RETRY_S)
        else:
            return
