"""Frames in and out of one node: what it hears, counters, the checks (docs/node.md, Protection)."""

from third_node.codec import MESSAGES, CanFrame, Fields, in_range, pack, unpack
from third_node.protection import Receiver, crc_is_right, protect

ESTOP, NMT, SYNC, MASTER_BEAT = 0x000, 0x001, 0x080, 0x708
OF_SETPOINT = (0x140, 0x141, 0x142, 0x144, 0x145, 0x148)


class Speaker:
    """Identifiers of a joint, its receivers and its counters."""

    def __init__(self, joint: int) -> None:
        n = self.joint = joint
        self.id_emcy, self.id_config_ack, self.id_beat = 0x080 + n, 0x580 + n, 0x700 + n
        self.id_error, self.id_dac = 0x200 + n, 0x280 + n
        self.id_measure, self.id_reference = 0x100 + n, 0x180 + n
        self.id_rows, self.id_config = 0x300 + n, 0x500 + n
        self.own = (self.id_emcy, self.id_config_ack, self.id_beat, self.id_error, self.id_dac)
        self.of_master = (NMT, SYNC, self.id_rows, self.id_config, *OF_SETPOINT)
        heard = (*self.own, *self.of_master, MASTER_BEAT, self.id_measure, self.id_reference)
        others = [0x200 + j for j in range(1, 7)]
        self.receivers = {can_id: Receiver() for can_id in (*heard, *others)}
        self.counters: dict[int, int] = {}
        self.out: list[CanFrame] = []
        self.discarded = 0
        self.heard_boots: dict[int, int] = {}  # the last HEARTBEAT of each identifier

    def checked(self, can_id: int, data: bytes, fd: bool) -> tuple[Fields | None, bool]:
        """The fields of a frame that is right, and whether its counter is in step."""
        protected = can_id != ESTOP
        if (protected and not fd) or len(data) != MESSAGES[can_id].length:
            return None, False
        if protected and not crc_is_right(can_id, data):
            return None, False
        fields = unpack(can_id, data)
        if not in_range(can_id, fields):
            return None, False
        if not protected:
            return fields, True
        receiver = self.receivers[can_id]
        if can_id in (MASTER_BEAT, self.id_beat):
            if fields["boot_id"] != self.heard_boots.get(can_id):
                receiver.reset()
            self.heard_boots[can_id] = fields["boot_id"]
        return fields, receiver.check(fields["e2e_counter"])

    def send(self, can_id: int, fields: Fields) -> None:
        """Put a frame on the bus."""
        counter = self.counters.get(can_id, 0)
        self.counters[can_id] = (counter + 1) % 256
        self.out.append((can_id, protect(can_id, pack(can_id, fields), counter)))

    def reset_receivers(self, ids: tuple[int, ...] | None = None) -> None:
        """Take the next frame of these identifiers, by default of all, whatever its counter."""
        for can_id in self.receivers if ids is None else ids:
            self.receivers[can_id].reset()
