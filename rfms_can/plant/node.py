"""The plant as a node: integrates a period at every SYNC, samples, and latches DAC codes.

At SYNC k+1 the period is integrated with the codes latched at SYNC k, the boards are sampled, and
the codes of cycle k that have arrived are latched. A joint whose node has been silent for three
cycles is braked (``brake_watchdog.py``); all are until their nodes speak. When SYNC fails, physics
goes on: the plant then runs its periods by its own clock, and tells SYNC_MISSING in the third.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

from rfms_can.node.port_counts import PortTellingEndpoint
from rfms_can.node.protocol import NOTHING
from rfms_can.plant.brake_watchdog import BrakeWatchdog
from rfms_can.plant.physics import PlantPhysics
from rfms_can.tables import complete
from rfms_can.wire.configuration import plant_hash
from rfms_can.wire.contract import ESTOP_VALUES, LAST_CYCLE, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, HEARTBEAT_EVERY, JOINTS, MASTER, PLANT
from rfms_can.wire.records import Dac, Emcy, Estop, Force, Heartbeat, Measure, Nmt, Reference, Sync
from rfms_can.wire.vocabulary import DRIVEN, Command, FaultCode, NodeState

SYNC_BOUND: Final = 3
"""Periods in a row without SYNC after which the plant tells it: as the joints stop (R2)."""


class PlantNode(PortTellingEndpoint):
    """Node 9: seven boards, an arm and a jaw.

    Args:
        physics: boards, arm and gripper.
        wire, boot_id: see ``Endpoint``.
        watch_ns: time between two SYNCs, ns: the control period, or the barrier in lockstep.
        observe: called after each integrated period with the number of the cycle that begins; for
            observers of the physics.
    """

    def __init__(
        self,
        physics: PlantPhysics,
        wire: Wire,
        boot_id: int,
        watch_ns: int,
        observe: Callable[[int], None] | None = None,
    ) -> None:
        super().__init__(PLANT, wire, boot_id)
        self.physics = physics
        self.state = NodeState.INIT
        self.cycle = 0
        self._hash = plant_hash(physics.arm.arm_id, physics.steps_per_period * physics.step_s)
        self._watch_ns = watch_ns
        self._deadline_ns: int | None = 0
        self._observe = observe
        self._started = False
        self._stopped = False
        self._synchronised = False  # SYNC comes
        self._begun_by_sync = False  # the cycle under way
        self._unsynchronised = 0  # periods in a row without one
        self._bus_state = NodeState.PREOP
        self._arrived: list[Dac | None] = [None] * GRIPPER
        self._brakes = BrakeWatchdog(GRIPPER, len(JOINTS))
        self._codes = [0] * GRIPPER
        self._force_codes = [0] * len(JOINTS)
        self._measures = [self._sends(Measure, n) for n in (*JOINTS, GRIPPER)]
        self._references = [self._sends(Reference, n) for n in JOINTS]
        self._force = self._sends(Force, None)
        self._emcy = self._sends(Emcy, PLANT)
        self._hears(Estop, None, self._on_estop)
        self._hears(Nmt, None, self._on_command)
        self._hears(Heartbeat, MASTER, self._on_master)
        self._hears(Sync, None, self._on_sync)
        for n in (*JOINTS, GRIPPER):
            self._hears(Dac, n, partial(self._on_dac, n - 1))

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Boot; later run a period whose SYNC is missing."""
        if self._deadline_ns is None or now_ns < self._deadline_ns:
            return NOTHING
        if self.state is NodeState.INIT:
            self.state = NodeState.PREOP
            self._deadline_ns = None
            self._announce()
        else:
            self._synchronised = False
            self._deadline_ns += self._watch_ns
            self._run_period(self.cycle + 1 & LAST_CYCLE, self._bus_state)
            self._miss_sync()
        return self._flush()

    def next_deadline_ns(self) -> int | None:
        """When the plant runs a period without a SYNC."""
        return self._deadline_ns

    def braked(self, index: int) -> bool:
        """Whether the brake of a board (0 to 6) is closed."""
        return self._brakes.closed(index)

    def _announce(self) -> None:
        self._beat(self.state, config_hash=self._hash)

    def _miss_sync(self) -> None:
        """One more period without SYNC; in the third it says so: who hears it knows who is deaf."""
        self._unsynchronised += 1
        if self._unsynchronised == SYNC_BOUND and self._bus_state in DRIVEN:
            sync, bound = self.wire.id(Sync), float(SYNC_BOUND)
            fault = FaultCode.SYNC_MISSING
            register = 1 << fault | 1
            low = self.cycle & 0xFF
            self._out.append(self._emcy.frame(fault, MASTER, sync, bound, bound, low, register))

    def _on_sync(self, sync: Sync) -> None:
        if sync.dbc_hash != self.wire.dbc_hash:
            self.ignored["SYNC with another DBC"] += 1
            return
        self.state = NodeState.OPERATIONAL
        ended, self._bus_state = self._bus_state, NodeState(sync.state)
        self._synchronised = True
        self._unsynchronised = 0
        self._deadline_ns = self._now_ns + self._watch_ns * 3 // 2
        if sync.cycle % HEARTBEAT_EVERY == 0:
            self._announce()
        self._run_period(sync.cycle, ended)

    def _run_period(self, cycle: int, ended: NodeState) -> None:
        """Integrate the period that ends now, latch the codes received in it, sample.

        Args:
            cycle: that begins.
            ended: what SYNC said of the one that ends.
        """
        if self._started:
            self.physics.jaw.set_motor_current(self._codes[GRIPPER - 1])
            brakes = [self._brakes.closed(index) for index in range(len(JOINTS))]
            self.physics.step_period(self._codes[: len(JOINTS)], self._force_codes, brakes)
        self._started = True
        self._latch(ended)
        self.cycle = cycle
        if self._observe is not None:
            self._observe(cycle)
        self._sample(cycle & 0xFF)

    def _latch(self, ended: NodeState) -> None:
        """Apply the received codes; a joint without a frame keeps its codes until it is braked."""
        heard = [dac is not None for dac in self._arrived]
        closing = self._brakes.end_cycle(
            heard,
            driven=ended in DRIVEN,
            together=ended is not NodeState.HOMING,
            synchronised=self._begun_by_sync,
        )
        self._begun_by_sync = self._synchronised
        for index in closing:
            self._power_off(index)  # no current against a closed brake
        for index, dac in enumerate(self._arrived):
            if dac is None:
                continue
            self._codes[index] = dac.current_dac
            if index < len(JOINTS):
                self._force_codes[index] = dac.force_dac
            self._arrived[index] = None

    def _power_off(self, index: int) -> None:
        """Zero to both DACs."""
        self._codes[index] = 0
        if index < len(JOINTS):
            self._force_codes[index] = 0

    def _sample(self, low: int) -> None:
        """MEASURE of every board, FORCE with a sensor; REFERENCE too while the bus homes."""
        physics, out = self.physics, self._out
        for index, (counts, current, velocity, index_seen) in enumerate(physics.sample()):
            braked = self._brakes.closed(index)
            out.append(
                self._measures[index].frame(counts, current, velocity, low, index_seen, braked)
            )
        counts, current = physics.jaw.sample()
        out.append(self._measures[-1].frame(counts, current, 0, low, 0, 0))
        force = physics.sample_force()
        if force is not None:
            out.append(self._force.frame(*force, low))
        if self._bus_state is NodeState.HOMING:
            for index, sender in enumerate(self._references):
                latched = physics.latched_index_counts(index)
                out.append(
                    sender.frame(physics.coarse(index), latched or 0, int(latched is not None), low)
                )

    def _on_dac(self, index: int, dac: Dac) -> None:
        """Accept a code of the current cycle; a code of another cycle is stale."""
        if self._stopped:
            self.ignored["DAC after ESTOP"] += 1
        elif self._brakes.lost(index):
            self.ignored["DAC of a node that was lost"] += 1
        elif dac.cycle == self.cycle & 0xFF:
            self._arrived[index] = dac
        else:
            self.ignored["stale DAC"] += 1

    def _on_master(self, beat: Heartbeat) -> None:
        """A master that has started again counts from 0; not one beside a master that drives."""
        if not (self._synchronised and self._bus_state in DRIVEN):
            self._note_boot(MASTER, beat.boot_id)

    def _on_command(self, nmt: Nmt) -> None:
        if nmt.node not in (0, self.number):
            return
        reaction = _REACTIONS.get(nmt.command)
        if reaction is not None:
            reaction(self)

    def _start(self) -> None:
        self._restart_counters()
        self._brakes.start()

    def _stop(self) -> None:
        self._bus_state = NodeState.READY  # nodes are told to fall silent: none is lost by it

    def _reset(self) -> None:
        self._forget_counters()
        self._stopped = False
        self._bus_state = NodeState.PREOP
        self._brakes.reset()

    def _on_estop(self, estop: Estop) -> None:
        """Torque off and brakes on, whatever the nodes say, until RESET."""
        if estop == ESTOP_VALUES:
            self._stopped = True
            for index in range(GRIPPER):
                self._power_off(index)
            self._brakes.close_all()
            self._arrived = [None] * GRIPPER


_REACTIONS: Final[dict[int, Callable[[PlantNode], None] | None]] = complete(
    {
        Command.ANNOUNCE: PlantNode._announce,
        Command.HOME: None,
        Command.START: PlantNode._start,
        Command.STOP: PlantNode._stop,
        Command.RESET: PlantNode._reset,
        Command.QUICKSTOP: None,
    },
    Command,
)
"""What a command does; moving is the joints' business, which the plant feels."""
