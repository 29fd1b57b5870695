"""CRC, data IDs and counters (docs/node.md, Protection)."""

WINDOW = 16
RESTART = 3


def crc16(data: bytes, crc: int = 0xFFFF) -> int:
    """CRC-16/CCITT-FALSE."""
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ 0x1021 if crc & 0x8000 else crc << 1
            crc &= 0xFFFF
    return crc


def data_id(can_id: int) -> int:
    """What goes into the CRC of an identifier."""
    return 0x5200 + can_id


def frame_crc(can_id: int, data: bytes) -> int:
    """The CRC that a payload must have."""
    identity = data_id(can_id)
    return crc16(bytes(data[2:]) + bytes([identity & 0xFF, identity >> 8]))


def protect(can_id: int, payload: bytes, counter: int) -> bytes:
    """A payload with its counter and CRC put in."""
    data = bytearray(payload)
    data[2] = counter
    crc = frame_crc(can_id, bytes(data))
    data[0] = crc & 0xFF
    data[1] = crc >> 8
    return bytes(data)


def crc_is_right(can_id: int, data: bytes) -> bool:
    """Whether bytes 0 and 1 fit the rest."""
    return frame_crc(can_id, data) == data[0] + 256 * data[1]


class Receiver:
    """The counter of one identifier that is heard."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Take the next frame whatever its counter."""
        self.last: int | None = None
        self.provisional = False
        self.stray = 0
        self.row = 0
        self.needed = RESTART

    def check(self, counter: int) -> bool:
        """Whether the frame is taken."""
        if self.last is None:
            self.last = counter
            self.provisional = True
            return True
        step = (counter - self.last) % 256
        if not (1 <= step <= WINDOW or (self.provisional and step > 0)):
            if self.row > 0 and 1 <= (counter - self.stray) % 256 <= WINDOW:
                self.row += 1
            else:
                self.row = 1
            self.stray = counter
            if self.row != self.needed:
                return False
            self.needed *= 2
        self.row = 0  # a frame was taken: the strays before are forgotten
        self.last = counter
        self.provisional = False
        return True
