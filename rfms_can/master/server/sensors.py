"""Sensors: sessions that may observe the references granted to them and nothing else (VI.2).

A grant is the coordinator's, and ends with its lease, or the server's configuration, and lasts.
Observations move the arm: they count only while a coordinator controls it.
"""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from rfms_can.errors import LeaseError
from rfms_can.master.node import MasterNode
from rfms_can.master.phases import Phase
from rfms_can.master.server.lease import Lease
from rfms_can.messages import AnyRequest, GrantRequest, SensorRequest, TransformMessage
from rfms_can.messages.sensors import MAX_SENSORS


@dataclass(slots=True)
class Attached:
    """A session that is a sensor.

    Attributes:
        name: of the sensor.
        duration_ns: after so long without a message of it, it is silent.
        expires_ns: when it will be.
        live: whether it is not.
    """

    name: str
    duration_ns: int
    expires_ns: int
    live: bool = True


class Sensors:
    """Who may observe what, and which sensors are there.

    Args:
        master: whose references they observe.
        lease: of the coordinator.
        events: lines for a person at the server.
        configured: references by sensor that the server itself grants.

    Attributes:
        states: by sensor ``granted``, ``live`` or ``silent``, for the status.
    """

    def __init__(
        self,
        master: MasterNode,
        lease: Lease,
        events: deque[str],
        configured: Mapping[str, Sequence[str]],
    ) -> None:
        self.states: dict[str, str] = {}
        self._master = master
        self._lease = lease
        self._events = events
        self._configured: Final = {name: tuple(names) for name, names in configured.items()}
        self._granted: dict[str, tuple[str, ...]] = {}
        self._holder: str | None = None
        self._attached: dict[str, Attached] = {}
        self._ended: list[str] = []
        self._tell()

    # --- grants -------------------------------------------------------------------------------

    def grant(self, request: GrantRequest) -> None:
        """The holder of the lease says what a sensor may observe.

        Raises:
            LeaseError: too many sensors.
        """
        name, references = request.sensor, tuple(dict.fromkeys(request.references))
        known = {**self._configured, **self._granted}
        if name not in known and len(known) >= MAX_SENSORS:
            raise LeaseError(
                f"sensor {name!r} would be one of {len(known) + 1} with a grant, {MAX_SENSORS} may "
                f"be: revoke another one's first"
            )
        self._granted.pop(name, None)
        if references:
            self._granted[name] = references
        self._grants_changed()

    def references(self, name: str) -> tuple[str, ...]:
        """What a sensor may observe: of the coordinator, or else of the configuration."""
        return self._granted.get(name) or self._configured.get(name, ())

    # --- sessions -----------------------------------------------------------------------------

    def handle(self, word: str, request: SensorRequest, now_ns: int) -> None:
        """Do what a session asks that is a sensor or wants to be one.

        Raises:
            LeaseError: it has no grant, the name is taken, or the session controls the arm.
        """
        _ACTIONS[request.action](self, word, request, now_ns)

    def heard(self, word: str, now_ns: int) -> None:
        """A session has spoken: if it is a sensor, it is there."""
        sensor = self._attached.get(word)
        if sensor is None:
            return
        if not sensor.live:
            sensor.live = True
            self._events.append(f"sensor {sensor.name!r} is back")
            self._tell()
        sensor.expires_ns = now_ns + sensor.duration_ns

    def check(self, word: str, request: AnyRequest) -> bool:
        """See whether a session is a sensor, and if so that it may ask this.

        Raises:
            LeaseError: it may not.
        """
        sensor = self._attached.get(word)
        if sensor is None:
            return False
        name, references = sensor.name, self.references(sensor.name)
        tag = request.__struct_config__.tag
        self._check_grant(name, references)
        if not isinstance(request, TransformMessage) or request.kind != "reference":
            what = f"{tag} of kind {request.kind}" if hasattr(request, "kind") else f"{tag}"
            raise LeaseError(
                f"sensor {name!r} may observe references and nothing else, it asked for {what}: "
                f"let a coordinator ask, in a session of its own"
            )
        if request.name not in references:
            raise LeaseError(
                f"sensor {name!r} may observe {listed(references)}, not {request.name!r}: the "
                f"coordinator may grant it with arm.grant, the server with --grant"
            )
        if self._lease.holder is None:
            raise self._over(name)
        return True

    def check_wait(self, word: str) -> None:
        """See that a session, if it is a sensor, does not wait in vain.

        Raises:
            LeaseError: it observes nothing now.
        """
        sensor = self._attached.get(word)
        if sensor is not None and (self._lease.holder is None or not self.references(sensor.name)):
            raise self._over(sensor.name)

    def all_wait(self, waits: Callable[[str], bool]) -> bool:
        """Whether no sensor that is there keeps the clock from going on, where it is kept."""
        return all(
            waits(word)
            for word, sensor in self._attached.items()
            if sensor.live and self.references(sensor.name)
        )

    # --- time ---------------------------------------------------------------------------------

    def look(self, now_ns: int) -> list[tuple[str, LeaseError]]:
        """See which sensors are silent, and whether the coordinator's session has ended.

        Returns:
            Words of the sessions that observe nothing any more, and the error for their waits.
        """
        for sensor in self._attached.values():
            if sensor.live and now_ns >= sensor.expires_ns:
                sensor.live = False
                seconds = sensor.duration_ns * 1e-9
                self._settle(sensor.name, f"has said nothing for {seconds:g} s")
        if self._holder != self._lease.holder:
            self._holder = self._lease.holder
            self._granted.clear()
            self._tell()
            self._ended = list(self._attached)
        ended, self._ended = self._ended, []
        return [(word, self._over(self._attached[word].name)) for word in ended]

    # --- details ------------------------------------------------------------------------------

    def _attach(self, word: str, request: SensorRequest, now_ns: int) -> None:
        name = request.name
        references = self.references(name)
        self._check_grant(name, references)
        if word == self._lease.holder:
            raise LeaseError(
                f"sensor {name!r}: this session controls the arm and may observe anyway; connect "
                f"a sensor in a session of its own"
            )
        other = self._live_one(name)
        if other is not None and other != word:
            left = max(0, self._attached[other].expires_ns - now_ns) * 1e-9
            raise LeaseError(
                f"sensor {name!r} is another session, for {left:.2f} s yet if it says nothing: "
                f"wait, or take another name that is granted"
            )
        for known in [key for key, one in self._attached.items() if one.name == name]:
            del self._attached[known]
            self._ended = [one for one in self._ended if one != known]
        duration_ns = round(request.duration_s * 1e9)
        self._attached[word] = Attached(name, duration_ns, now_ns + duration_ns)
        self._events.append(f"sensor {name!r} observes {listed(references)}")
        self._tell()

    def _renew(self, word: str, request: SensorRequest, now_ns: int) -> None:
        sensor = self._attached.get(word)
        if sensor is None or sensor.name != request.name:
            raise LeaseError(f"this session is not sensor {request.name!r}: attach first")
        self._check_grant(sensor.name, self.references(sensor.name))
        sensor.duration_ns = round(request.duration_s * 1e9)
        sensor.expires_ns = now_ns + sensor.duration_ns

    def _detach(self, word: str, request: SensorRequest, now_ns: int) -> None:
        sensor = self._attached.pop(word, None)
        self._ended = [one for one in self._ended if one != word]
        if sensor is not None:
            self._settle(sensor.name, "has left")

    def _settle(self, name: str, why: str) -> None:
        """Nothing more comes of a sensor: what it observed rests where it would have been soon."""
        references = self.references(name)
        if self._master.phase is Phase.RUN:
            for reference in references:
                self._master.motion.settle(reference)
        tail = f"; not observed: {listed(references)}" if references else ""
        self._events.append(f"sensor {name!r} {why}{tail}")
        self._tell()

    def _grants_changed(self) -> None:
        """Those whose grant has ended wait in vain."""
        sensors = self._attached.items()
        self._ended = [word for word, one in sensors if not self.references(one.name)]
        self._tell()

    def _check_grant(self, name: str, references: Sequence[str]) -> None:
        if not references:
            raise self._no_grant(name)

    def _over(self, name: str) -> LeaseError:
        """Why a sensor observes nothing now."""
        if self.references(name):
            return LeaseError(
                f"sensor {name!r} observes nothing, as no coordinator controls the arm: wait until "
                f"one does (lease in the status)"
            )
        return self._no_grant(name)

    def _no_grant(self, name: str) -> LeaseError:
        known = sorted({**self._configured, **self._granted})
        return LeaseError(
            f"sensor {name!r} has no grant, or no longer: the coordinator gives it with "
            f"arm.grant({name!r}, [...]), the server with --grant {name}=REFERENCE; sensors with "
            f"one: {listed(known)}"
        )

    def _live_one(self, name: str) -> str | None:
        """Word of the session that is this sensor now."""
        words = (w for w, one in self._attached.items() if one.live and one.name == name)
        return next(words, None)

    def _tell(self) -> None:
        """Bring ``states`` up to date."""
        states = dict.fromkeys({**self._configured, **self._granted}, "granted")
        for sensor in self._attached.values():
            if sensor.name in states:
                states[sensor.name] = "live" if sensor.live else "silent"
        self.states = states


_ACTIONS: Final[dict[str, Callable[[Sensors, str, SensorRequest, int], None]]] = {
    "attach": Sensors._attach,
    "renew": Sensors._renew,
    "detach": Sensors._detach,
}


def listed(names: Sequence[str]) -> str:
    """Names as a sentence has them."""
    return ", ".join(map(repr, names)) or "none"
