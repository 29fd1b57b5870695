"""The life of a node, whatever it drives: frames, NMT, CONFIG, HEARTBEAT, SYNC, faults.

docs/node.md has the sections of the same names. Times are ns of the node's own clock.
"""

from third_node.bus_watch import BAD_IN_A_ROW, WITHIN_CYCLES, BusWatch
from third_node.codec import DBC_HASH, CanFrame, Fields
from third_node.configuration import COMMIT, REFUSED_STATE, Configuration, hash_of
from third_node.faults import (
    AT_ONCE,
    BAD_FRAMES,
    DAMP,
    DBC_MISMATCH,
    DUPLICATE_NODE,
    EMERGENCY_STOP,
    FOREIGN_MASTER,
    HOLD,
    NOTHING,
    OFF,
    STOP,
    SYNC_MISSING,
    rung,
)
from third_node.integral import clamp
from third_node.speaker import ESTOP, MASTER_BEAT, NMT, SYNC, Speaker

INIT, PREOP, HOMING, READY, OPERATIONAL, QUICKSTOP, FAULT = range(7)
STATES = ("INIT", "PREOP", "HOMING", "READY", "OPERATIONAL", "QUICKSTOP", "FAULT")
ANNOUNCE, NMT_HOME, NMT_START, NMT_STOP, NMT_RESET, NMT_QUICKSTOP = range(6)
DRIVEN = (HOMING, OPERATIONAL, QUICKSTOP)

MASTER = 8
HEARTBEAT_EVERY = 12
LETTERS = {"code": 0x504F5453, "inverse": 0xAFB0ABAC}


class Life(Speaker):
    """What every state has, and what joints do not differ in."""

    def __init__(self, joint: int, boot_id: int) -> None:
        super().__init__(joint)
        self.boot_id = boot_id
        self.state = INIT
        self.master_boot: int | None = None
        self.config = Configuration(joint)
        self.bus = BusWatch()
        self.clear_faults()
        self.deadline_ns: int | None = None
        self.watch_ns = self.period_ns = 0
        self.in_time = False
        self.cycle = -1  # its number, as SYNC had it
        self.sync_state = INIT  # the state in the last SYNC

    # --- what a joint does about it

    def on_frame_of_joint(self, can_id: int, fields: Fields) -> None:
        """A frame of the cycle."""
        raise NotImplementedError

    def on_cycle(self, fields: Fields, was_driven: bool) -> None:
        """SYNC; ``was_driven``: the joint was in the cycle that is over."""
        raise NotImplementedError

    def on_lost_sync(self) -> None:
        """The watchdog of SYNC ran off."""
        raise NotImplementedError

    def on_new_set(self) -> None:
        """A configuration is in force."""
        raise NotImplementedError

    def on_void_set(self) -> None:
        """The configuration is void."""
        raise NotImplementedError

    def on_state(self, event: str) -> None:
        """HOME, START, or a way into PREOP or QUICKSTOP."""
        raise NotImplementedError

    def sender_of(self, can_id: int) -> int:
        """Whose frame it is."""
        raise NotImplementedError

    def is_driven(self) -> bool:
        """Whether DAC goes out now."""
        raise NotImplementedError

    def send_zero(self) -> None:
        """The DAC 0 of OFF."""
        raise NotImplementedError

    # --- from outside

    def start(self) -> list[CanFrame]:
        """Power on; what the node sends."""
        self.out = []
        self.state = PREOP
        self.send_heartbeat()
        return self.out

    def tick(self, now_ns: int) -> list[CanFrame]:
        """Time passes; what the node sends."""
        self.out = []
        while self.deadline_ns is not None and now_ns >= self.deadline_ns:
            self.deadline_ns += self.period_ns  # of either clock: once one is missed, each period
            self.in_time = False
            self.count(SYNC_MISSING, MASTER, SYNC)
            self.on_lost_sync()
        return self.out

    def receive(self, can_id: int, data: bytes, now_ns: int, fd: bool = True) -> list[CanFrame]:
        """A frame comes; what the node sends."""
        out = self.tick(now_ns)
        if can_id != ESTOP and can_id not in self.receivers:
            return out
        fields, in_step = self.checked(can_id, bytes(data), fd)
        if fields is not None and in_step:
            self.act(can_id, fields, now_ns)
            return out
        self.discarded = min(self.discarded + 1, 65535)
        if fields is None:
            self.on_bad_frame(can_id)
        elif can_id == SYNC and fields["dbc_hash"] == DBC_HASH:
            self.is_foreign(fields["cycle"])
        return out

    def send_heartbeat(self) -> None:
        """HEARTBEAT."""
        fields = {
            "state": self.state,
            "error_register": self.register,
            "boot_id": self.boot_id,
            "dbc_hash": DBC_HASH,
            "config_hash": self.config.hash,
            "discarded": self.discarded,
        }
        self.send(self.id_beat, fields)

    # --- what comes in

    def act(self, can_id: int, fields: Fields, now_ns: int) -> None:
        """A frame that was taken."""
        if can_id in self.own:
            self.trip(DUPLICATE_NODE, self.joint, can_id, 1.0, 0.0)
        elif can_id == ESTOP:
            if {name: fields[name] for name in LETTERS} == LETTERS:
                self.trip(EMERGENCY_STOP, 0, 0, 0.0, 0.0)
        elif can_id == NMT:
            if fields["node"] in (0, self.joint):
                self.on_nmt(fields["command"], fields["argument"])
        elif can_id == SYNC:
            self.on_sync(fields, now_ns)
        elif can_id == self.id_config:
            self.on_config(fields)
        elif can_id == MASTER_BEAT:
            self.on_master(fields["boot_id"])
        else:
            self.on_frame_of_joint(can_id, fields)

    def on_master(self, boot_id: int) -> None:
        """HEARTBEAT_8."""
        is_led = self.config.values is not None and self.in_time and self.sync_state in DRIVEN
        obeyed, self.bus.obeyed = self.bus.obeyed, False
        if is_led and self.master_boot is not None:
            if obeyed:
                self.master_boot = boot_id
            elif boot_id != self.master_boot and self.is_watched() and self.bus.led:
                numbers = (float(boot_id), float(self.master_boot))
                self.trip(FOREIGN_MASTER, MASTER, MASTER_BEAT, *numbers)
            return
        if not is_led and boot_id != self.master_boot:
            self.reset_receivers(self.of_master)
        self.master_boot = boot_id

    # --- NMT

    def on_nmt(self, command: int, argument: int) -> None:
        """A command for this node."""
        if command == NMT_START:
            if self.state == READY and argument in (0, self.config.hash):
                self.on_start()
            return
        actions = {
            ANNOUNCE: self.send_heartbeat,
            NMT_HOME: self.on_home,
            NMT_STOP: self.on_stop,
            NMT_RESET: self.on_reset,
            NMT_QUICKSTOP: self.stop,
        }
        actions[command]()

    def on_home(self) -> None:
        """HOME."""
        if self.state in (PREOP, READY) and self.config.values and self.reaction <= HOLD:
            self.state = HOMING
            self.bus.begin()
            self.on_state("HOME")

    def on_stop(self) -> None:
        """STOP."""
        if self.state == HOMING:
            self.go_preop()
        elif self.state == OPERATIONAL:
            self.state = READY

    def on_start(self) -> None:
        """START."""
        self.state = OPERATIONAL
        self.clear_faults()
        self.reset_receivers()
        self.counters = {}
        self.bus.begin()
        self.on_state("START")

    def on_reset(self) -> None:
        """RESET."""
        if self.state in (INIT, OPERATIONAL):
            return
        self.clear_faults()
        self.reset_receivers()
        self.bus.forget_bad()
        self.bus.obeyed = True
        if self.config.values is None:
            self.config.clear()
        self.go_preop()

    def go_preop(self) -> None:
        """Every way into PREOP."""
        self.state = PREOP
        self.on_state("PREOP")

    def stop(self) -> None:
        """The controlled stop: by QUICKSTOP and by faults."""
        if self.state == HOMING:
            self.go_preop()
        elif self.state == OPERATIONAL:  # a stop under way goes on
            self.state = QUICKSTOP
            self.on_state("QUICKSTOP")

    # --- CONFIG

    def on_config(self, fields: Fields) -> None:
        """CONFIG, and its answer."""
        number, value = fields["parameter"], fields["value"]
        its_hash = 0
        if self.state != PREOP:
            status = REFUSED_STATE
        elif number == COMMIT:
            its_hash = hash_of(self.config.held)
            status, new = self.config.commit(fields["total"], fields["hash"])
            if new and self.config.values is not None:
                self.watch_ns = round(self.config.values.watch_s * 1e9)
                self.period_ns = round(self.config.values.PERIOD * 1e9)
                self.on_new_set()
        else:
            status, void = self.config.parameter(number, value)
            if void:
                self.deadline_ns, self.in_time = None, False
                self.on_void_set()
        ack = {"parameter": number, "status": status, "value": value, "hash": its_hash}
        self.send(self.id_config_ack, ack)

    # --- SYNC

    def on_sync(self, fields: Fields, now_ns: int) -> None:
        """SYNC."""
        if fields["dbc_hash"] != DBC_HASH:
            cause = (MASTER, SYNC, float(fields["dbc_hash"]), float(DBC_HASH))
            self.trip(DBC_MISMATCH, *cause)
            return
        if self.is_foreign(fields["cycle"]):
            return
        was_driven = self.is_driven()
        self.bus.led = True
        self.ladder[SYNC_MISSING] = 0
        self.cycle = fields["cycle"]
        self.sync_state = fields["state"]
        self.in_time = True
        if self.config.values is not None:
            self.deadline_ns = now_ns + self.watch_ns * 3 // 2
        if self.cycle % HEARTBEAT_EVERY == 0:
            self.send_heartbeat()
        self.on_cycle(fields, was_driven)

    def is_foreign(self, cycle: int) -> bool:
        """Whether SYNC of a cycle is another master's; it stops the joint then."""
        missed = self.ladder.get(SYNC_MISSING, 0)
        foreign = self.is_watched() and self.bus.is_foreign(cycle, self.cycle, missed)
        if foreign:
            self.trip(FOREIGN_MASTER, MASTER, SYNC, float(cycle), float(self.cycle))
        return foreign

    def on_bad_frame(self, can_id: int) -> None:
        """A frame that was refused, not for its counter."""
        if self.is_watched() and self.bus.is_bad_again(can_id, self.cycle):
            numbers = (float(BAD_IN_A_ROW), float(WITHIN_CYCLES))
            self.trip(BAD_FRAMES, self.sender_of(can_id), can_id, *numbers)

    # --- faults

    def is_watched(self) -> bool:
        """Whether the ladder counts, and the bus is watched."""
        return self.state in DRIVEN or self.damps()

    def clear_faults(self) -> None:
        """START and RESET."""
        self.register = 0
        self.reaction = NOTHING
        self.ladder: dict[int, int] = {}  # fault, cycles in a row

    def damps(self) -> bool:
        """Whether a fault has come to damping."""
        return self.state == FAULT and self.reaction == DAMP

    def count(
        self,
        fault: int,
        culprit: int,
        frame: int,
        value: float | None = None,
        bound: float | None = None,
    ) -> None:
        """One more cycle in a row; value and bound are the count and its rung by default."""
        if not self.is_watched():
            return
        n = self.ladder[fault] = self.ladder.get(fault, 0) + 1
        reaction, reached = rung(fault, n)
        numbers = (n if value is None else value, reached if bound is None else bound)
        self.react(reaction, fault, culprit, frame, *numbers)

    def trip(self, fault: int, culprit: int, frame: int, value: float, bound: float) -> None:
        """A fault that happens at once."""
        self.react(AT_ONCE[fault], fault, culprit, frame, value, bound)

    def react(
        self, reaction: int, fault: int, culprit: int, frame: int, value: float, bound: float
    ) -> None:
        """The error register, EMCY, and what the joint does about it."""
        self.register |= 1 | 1 << fault
        if reaction <= HOLD or reaction <= self.reaction:
            return
        was_driven = self.is_driven()
        self.reaction = reaction
        fields = {
            "fault": fault,
            "culprit": culprit,
            "frame": frame,
            "value": clamp(value, 1e9),
            "bound": clamp(bound, 1e9),
            "cycle": self.cycle & 0xFF,
            "error_register": self.register,
        }
        self.send(self.id_emcy, fields)
        if reaction == STOP:
            if fault == DUPLICATE_NODE and self.state == READY:
                self.go_preop()
            self.stop()
            return
        self.state = FAULT
        if reaction == OFF and was_driven:
            self.send_zero()
