"""A node's configuration on the wire: float32 values and their hash."""

import binascii
import struct
from collections.abc import Mapping
from typing import Final

from rfms_can.wire.vocabulary import Parameter

_PAIR: Final = struct.Struct("<Bf")


def configuration_hash(values: Mapping[Parameter, float]) -> int:
    """CRC-16 (0x1021) of all parameter and value pairs in ascending order; never 0 (no hash)."""
    data = b"".join(_PAIR.pack(parameter, values[parameter]) for parameter in sorted(values))
    return binascii.crc_hqx(data, 0xFFFF) or 1


def plant_hash(arm_id: float, period_s: float) -> int:
    """Configuration hash of the plant: arm id and control period, s."""
    return configuration_hash({Parameter.ARM_ID: arm_id, Parameter.PERIOD: period_s})
