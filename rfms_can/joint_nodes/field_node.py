"""The bus life of a node: boot, NMT, configuration, heartbeat, SYNC watchdog, ladder, faults.

A node never raises on what the bus sends it: frames are discarded and counted, commands that the
state table does not have are ignored and counted. What a node does with its board is its
controller's, which exists as a whole from COMMIT on, or not at all.
"""

from collections import ChainMap, Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Final, NamedTuple, Protocol

from rfms_can.errors import KinematicsError
from rfms_can.joint_nodes.detectors.bus import (
    BAD_IN_WINDOW,
    WINDOW_CYCLES,
    BadFrames,
    PortWatch,
    SyncNumbers,
)
from rfms_can.joint_nodes.ladder import LADDERS, Ladder, Reaction, rung
from rfms_can.joint_nodes.states import COMMAND_EVENTS, Event, enter, successor
from rfms_can.node.port_counts import PortTellingEndpoint
from rfms_can.node.protocol import NOTHING
from rfms_can.wire.configuration import (
    DEFAULTS,
    PARAMETERS,
    Clock,
    configuration_hash,
    contradiction,
    sensor_sources,
)
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import DBC_NAMES, HEARTBEAT_EVERY, MASTER
from rfms_can.wire.protection import Receiver, Refusal
from rfms_can.wire.records import (
    Config,
    ConfigAck,
    Emcy,
    Estop,
    Heartbeat,
    Measure,
    Nmt,
    Reference,
    Sync,
)
from rfms_can.wire.vocabulary import (
    DRIVEN,
    Command,
    ConfigStatus,
    FaultCode,
    NodeState,
    Parameter,
)

EVERYONE: Final = 0
ANY_SENDER: Final = -1
"""In place of the sender of MEASURE and REFERENCE: the configuration names it."""
_NUMBERS: Final = {name: number for number, name in DBC_NAMES.items()}
_STATES: Final = tuple(NodeState)
_SYNC_MISSING: Final = FaultCode.SYNC_MISSING
_KNOWN: Final[dict[int, Parameter]] = {int(p): p for p in PARAMETERS}
_STOPS: Final = {FaultCode.DUPLICATE_NODE: Event.DUPLICATE}
"""Events of faults that stop a node in any state; of the others, which a driven node alone has,
QUICKSTOP."""
LARGEST: Final = 1e9
"""Largest magnitude of a number in EMCY."""

Parameters = Mapping[Parameter, float]
"""The configuration of a node, by parameter."""


class Cause(NamedTuple):
    """What an EMCY says of the reason for a fault.

    Attributes:
        culprit: number of the node whose doing it is; 0 if it is not known.
        frame: identifier of the message that was missing or wrong; 0 if it is about none.
        bound: what the fault's value has broken, in its unit.
    """

    culprit: int = 0
    frame: int = 0
    bound: float = 0.0


class Controller(Protocol):
    """What a configured node does with its board, as far as the bus life has to tell it."""

    @property
    def drives(self) -> bool:
        """Whether its DAC goes out now: another one would open a brake that is closed."""

    def enter(self, state: NodeState) -> None:
        """The node's state has changed to ``state``."""

    def begin_cycle(self, sync: Sync) -> None:
        """A SYNC came: the cycle before is over, a new one begins."""

    def lose_cycle(self) -> None:
        """A SYNC did not come."""


class FieldNode(PortTellingEndpoint):
    """A joint or gripper node as the bus sees it.

    Args:
        number: node number, 1 to 6 joints, 7 gripper.
        wire, boot_id: see ``PortTellingEndpoint``.
        needed: parameters of a whole configuration.
        optional: what it may have besides.
        build: makes the controller of a whole configuration.
        drop_torque: called once when the reaction to a fault is to switch the torque off, where
            the controller drove the board until then.

    Attributes:
        state: node state.
        cycle: number of the cycle under way.
        bus_state: state the master runs the bus in, by the last SYNC.
        reaction: to the faults so far; the higher, the harder.
        faults: faults detected since start, by code.
        parameters: the configuration as far as it has come in.
        config_hash: of the configuration in force; 0 without one.
        controller: what drives the board; None without a configuration.
        ladder: counts the cycles in a row with each fault.
        echo: whether the bus brings it what it sent itself; see ``hears_itself``.
    """

    echo: Final = False
    controller: Controller | None

    def __init__(
        self,
        number: int,
        wire: Wire,
        boot_id: int,
        needed: frozenset[Parameter],
        optional: frozenset[Parameter],
        build: Callable[[Parameters], Controller],
        drop_torque: Callable[[], None],
    ) -> None:
        self._heard: dict[int, tuple[Receiver[Any], int]] = {}  # with who sends it, by identifier
        super().__init__(number, wire, boot_id)
        self.state = NodeState.INIT
        self.cycle = -1
        self.bus_state = NodeState.INIT
        self.faults: Counter[FaultCode] = Counter()
        self.reaction = Reaction.NONE
        self.parameters: dict[Parameter, float] = {}
        self.config_hash = 0
        self.controller = None
        self.ladder = Ladder()
        self._needed = needed
        self._known = frozenset(map(int, optional | needed))
        self._closed = False  # a COMMIT has come since the first parameter
        # samples come in MEASURE from the bus: a node of ours has no sensors of its own
        self._sources = sensor_sources(number) - {number}
        self._build = build
        self._drop_torque = drop_torque
        self._deadline_ns: int | None = 0
        self._synchronised = False  # SYNC comes in time
        self._obeyed = False  # RESET was taken since the last HEARTBEAT of a master
        self._watch_ns = 0  # longest time between two SYNCs, ns, once configured
        self._again_ns = 0  # from one that did not come to the next, ns
        self._numbers = SyncNumbers()
        self._bad_frames = BadFrames()
        self._port = PortWatch()
        self._emcy = self._sends(Emcy, number)
        self._ack = self._sends(ConfigAck, number)
        self._hears(Estop, None, self._on_estop)
        self._hears(Nmt, None, self._on_command)
        self._hears(Heartbeat, MASTER, self._on_master)
        self._hears(Sync, None, self._on_sync)
        self._handlers[self.wire.id(Sync)] = (self._take_sync, self._on_sync)
        self._hears(Config, number, self._on_config)
        for record in (Heartbeat, Emcy, ConfigAck):
            self._hears_itself(record)

    def _hears_itself(self, record: type[NamedTuple]) -> None:
        """Register a frame of the node's own: one that is heard comes from a second node."""
        identifier = self.wire.id(record, self.number)
        self._hears(record, self.number, partial(self._on_own_frame, identifier))

    def _hears(
        self, record: type[NamedTuple], node: int | None, act: Callable[[Any], None]
    ) -> None:
        """Register a handler, and who is to blame for frames that are bad."""
        super()._hears(record, node, act)
        receiver = self._receivers[-1]
        sender = ANY_SENDER
        if record not in (Measure, Reference):
            names = receiver.decoder.codec.senders
            sender = _NUMBERS[next(iter(names))] if len(names) == 1 else 0
        self._heard[self.wire.id(record, node)] = (receiver, sender)

    # --- the node protocol --------------------------------------------------------------------

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Boot at first; later, a SYNC that did not come is one more miss on the ladder."""
        if self._deadline_ns is None or now_ns < self._deadline_ns:
            return NOTHING
        self._now_ns = now_ns
        if self.state is NodeState.INIT:
            self._deadline_ns = None
            self.change(Event.BOOT)
            self._announce()
        else:
            self._deadline_ns += self._again_ns
            self._synchronised = False
            self._watch_port()
            self.miss(FaultCode.SYNC_MISSING, Cause(MASTER, self.wire.id(Sync)))
            if self.controller is not None:
                self.controller.lose_cycle()
        return self._flush()

    def next_deadline_ns(self) -> int | None:
        """When the next SYNC is overdue."""
        return self._deadline_ns

    # --- for the controller -------------------------------------------------------------------

    def send(self, frame: Frame) -> None:
        """Put a frame on the bus."""
        self._out.append(frame)

    def change(self, event: Event) -> None:
        """A transition of our own.

        Raises:
            TransitionError: the table has none.
        """
        before, self.state = self.state, enter(self.state, event, self.name)
        if self.controller is not None and (self.state is not before or event is Event.RESET):
            self.controller.enter(self.state)

    def miss(self, fault: FaultCode, cause: Cause, value: float | None = None) -> None:
        """One more cycle with a fault: climb the ladder and do what it says.

        Args:
            fault: what is wrong.
            cause: who is to blame, and by which message.
            value: the number that broke the bound of ``cause``; without one, how many cycles the
                fault has lasted, against the rung of the ladder.
        """
        if self.watches:
            reaction = self.ladder.miss(fault)
            if value is None:
                value = float(self.ladder.misses[fault])
                cause = cause._replace(bound=float(rung(fault, reaction)))
            self._react(reaction, fault, cause, value)

    def trip(self, fault: FaultCode, cause: Cause, value: float) -> None:
        """A fault that happens at once: go to the one step of its ladder, in any state."""
        ((_, reaction),) = LADDERS[fault]
        self._react(reaction, fault, cause, value)

    def _react(self, reaction: Reaction, fault: FaultCode, cause: Cause, value: float) -> None:
        """Go at least as far up the ladder as ``reaction``; arguments as with ``miss``."""
        self.faults[fault] += 1
        if reaction <= Reaction.HOLD or reaction <= self.reaction:
            return
        driven = self.controller is not None and self.controller.drives
        self.reaction = reaction
        self.change(
            _STOPS.get(fault, Event.QUICKSTOP) if reaction is Reaction.STOP else Event.FAULT
        )
        numbers = (max(-LARGEST, min(LARGEST, x)) for x in (value, cause.bound))
        self.send(
            self._emcy.frame(
                *(fault, cause.culprit, cause.frame),
                *numbers,
                *(self.cycle & 0xFF, self.error_register),
            )
        )
        if reaction is Reaction.OFF and driven:
            self._drop_torque()

    @property
    def watches(self) -> bool:
        """Whether faults that last count: while it is driven, or brakes its motion."""
        return self.state in DRIVEN or self.reaction is Reaction.DAMP

    @property
    def error_register(self) -> int:
        """Faults since the last START or RESET: bit n for fault n, bit 0 for any."""
        bits = 0
        for fault in self.faults:
            bits |= 1 << fault | 1
        return bits

    # --- what comes in ------------------------------------------------------------------------

    def _take_sync(self, frame: Frame) -> Any:
        """As a receiver does; one that is refused for its counter may be of a second master."""
        receiver, _ = self._heard[frame.id]
        values = receiver.take(frame)
        if values is None:
            sync: Any = receiver.decoder.result
            if sync.__class__ is Sync and sync.dbc_hash == self.wire.dbc_hash:
                self._is_foreign(sync)
        return values

    def _is_foreign(self, sync: Sync) -> bool:
        """Whether a second master has sent it: no other has this cycle now."""
        numbers = self._numbers
        if not numbers.is_foreign(sync.cycle, self.ladder.misses[_SYNC_MISSING]):
            return False
        if not self.watches:
            numbers.reset()
            return False
        self._refuse_master(self.wire.id(Sync), sync.cycle, numbers.last or 0)
        return True

    def _refuse_master(self, frame: int, value: int, known: int) -> None:
        """Two masters: neither may drive."""
        cause = Cause(MASTER, frame, float(known))
        self.trip(FaultCode.FOREIGN_MASTER, cause, float(value))

    def _on_sync(self, sync: Sync) -> None:
        if sync.dbc_hash != self.wire.dbc_hash:
            self._refuse_database(sync)
            return
        if self._is_foreign(sync):
            return
        self._numbers.last = sync.cycle
        self._watch_port()
        self.ladder.clear(_SYNC_MISSING)
        self.cycle = sync.cycle
        self.bus_state = _STATES[sync.state]
        self._synchronised = self.config_hash != 0  # without one there is nothing to take over
        if self.config_hash:
            self._deadline_ns = self._now_ns + self._watch_ns * 3 // 2
        if sync.cycle % HEARTBEAT_EVERY == 0:
            self._announce()
        if self.controller is not None:
            self.controller.begin_cycle(sync)

    def _refuse_database(self, sync: Sync) -> None:
        """The master runs another DBC: nothing it sends can be trusted."""
        if self.faults[FaultCode.DBC_MISMATCH] or self.state is NodeState.INIT:
            self.ignored["SYNC with another DBC"] += 1
        else:
            cause = Cause(MASTER, self.wire.id(Sync), float(self.wire.dbc_hash))
            self.trip(FaultCode.DBC_MISMATCH, cause, float(sync.dbc_hash))

    def _on_master(self, beat: Heartbeat) -> None:
        """A master that has started again counts from 0; not one beside a master that drives."""
        if self._synchronised and self.bus_state in DRIVEN:
            if self._obeyed:  # its RESET was taken, though SYNC of another was in time
                self._boots[MASTER] = beat.boot_id
            known = self._boots.setdefault(MASTER, beat.boot_id)
            if beat.boot_id != known and self.watches and self._numbers.last is not None:
                self._refuse_master(self.wire.id(Heartbeat, MASTER), beat.boot_id, known)
            elif beat.boot_id != known:
                self.ignored["HEARTBEAT of a second master"] += 1
        else:
            self._note_boot(MASTER, beat.boot_id)
        self._obeyed = False

    def _on_command(self, nmt: Nmt) -> None:
        if nmt.node not in (EVERYONE, self.number):
            return
        command = Command(nmt.command)
        if command is Command.ANNOUNCE:
            self._announce()
            return
        if command is Command.START and nmt.argument not in (0, self.config_hash):
            self.ignored["START for another configuration"] += 1
            return
        event = COMMAND_EVENTS[command]
        reason = self._refusal(command, event)
        if reason is not None:
            self.ignored[reason] += 1
            return
        if event in (Event.START, Event.RESET):
            self._forget_faults()
        if event in (Event.START, Event.RESET, Event.HOME):
            self._numbers.reset()
            self._bad_frames.reset()
        if event is Event.START:
            self._restart_counters()
        elif event is Event.RESET:
            self._forget_counters()
            self._obeyed = True
            if not self.config_hash:
                self._begin_set()  # what came in before is of no use to a master that starts
        self.change(event)

    def _refusal(self, command: Command, event: Event) -> str | None:
        """Why a command has no effect now; None if it has."""
        if successor(self.state, event) is None:
            return f"{command.name} in {self.state.name}"
        if event is Event.HOME and not self.config_hash:
            return "HOME without configuration"
        if event is Event.HOME and self.reaction is not Reaction.NONE:
            return "HOME before RESET"  # it was stopped while it homed
        return None

    def _forget_faults(self) -> None:
        """START and RESET begin with a clean record: no faults, no reaction."""
        self.reaction = Reaction.NONE
        self.ladder.reset()
        self.faults.clear()

    def _on_estop(self, estop: Estop) -> None:
        if estop == ESTOP_VALUES and self.state is not NodeState.INIT:
            self.trip(FaultCode.EMERGENCY_STOP, Cause(), 0.0)

    def _on_refused(self, frame: Frame) -> None:
        """A frame is bad, or its counter out of step: the first again and again means no good."""
        receiver, sender = self._heard[frame.id]
        if receiver.decoder.result.__class__ is not Refusal or not self.watches:
            return
        if self._bad_frames.too_many(frame.id, self.cycle):
            if sender == ANY_SENDER:
                sender = int(self.parameters[Parameter.SENSOR_SOURCE])
            cause = Cause(sender, frame.id, float(WINDOW_CYCLES))
            self.trip(FaultCode.BAD_FRAMES, cause, float(BAD_IN_WINDOW))

    def _watch_port(self) -> None:
        """The own controller: off the bus, or it has lost frames."""
        news = self._port.news(self.port_counts())
        if news.bus_offs > 0:
            self.trip(FaultCode.BUS_OFF, Cause(self.number), float(news.bus_offs))
        if news.overflows > 0:
            self.miss(FaultCode.QUEUE_OVERFLOW, Cause(self.number), float(news.overflows))
        else:
            self.ladder.clear(FaultCode.QUEUE_OVERFLOW)

    def _on_own_frame(self, identifier: int, _values: NamedTuple) -> None:
        """A second node sends as this one does: neither may drive."""
        if self.state is not NodeState.INIT:
            self.trip(FaultCode.DUPLICATE_NODE, Cause(self.number, identifier), 1.0)

    def _on_config(self, config: Config) -> None:
        status, digest = ConfigStatus.TAKEN, 0
        parameter = config.parameter
        if self.state is not NodeState.PREOP:
            status = ConfigStatus.REFUSED_STATE
        elif parameter == Parameter.COMMIT:
            digest = configuration_hash(self.parameters)
            status = self._commit(config, digest)
        elif parameter not in self._known:
            status = ConfigStatus.UNKNOWN
        elif PARAMETERS[_KNOWN[parameter]].refusal(config.value) is not None:
            status = ConfigStatus.REFUSED_VALUE
        else:
            if self._closed:
                self._begin_set()
            self.parameters[_KNOWN[parameter]] = config.value
        self.send(self._ack.frame(parameter, status, config.value, digest))

    def _begin_set(self) -> None:
        """Parameters come in for another configuration: the one in force is void."""
        self.controller, self.config_hash = None, 0
        self.parameters.clear()
        self._closed = False
        self._deadline_ns, self._synchronised = None, False

    def _commit(self, config: Config, digest: int) -> ConfigStatus:
        """Build the controller of the whole configuration, or none."""
        p = self.parameters
        self._closed = True
        if len(p) != config.total or digest != config.hash or not self._needed <= p.keys():
            return ConfigStatus.WRONG_HASH
        if self.config_hash == digest:
            return ConfigStatus.TAKEN  # the same again: what is built stays, its reference too
        if p[Parameter.SENSOR_SOURCE] not in self._sources:
            return ConfigStatus.UNSUPPORTED
        if contradiction({**DEFAULTS, **p}) is not None:
            return ConfigStatus.REFUSED_VALUE
        try:
            self.controller = self._build(ChainMap(p, DEFAULTS))
        except KinematicsError:
            return ConfigStatus.UNSUPPORTED
        self.config_hash = digest
        lockstep = p[Parameter.CLOCK] == Clock.LOCKSTEP
        watch_s = p[Parameter.BARRIER if lockstep else Parameter.PERIOD]
        self._watch_ns = round(watch_s * 1e9)
        self._again_ns = round(p[Parameter.PERIOD] * 1e9)
        return ConfigStatus.TAKEN

    def _announce(self) -> None:
        self._beat(self.state, self.error_register, self.config_hash)
