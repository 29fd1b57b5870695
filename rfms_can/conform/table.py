"""The checks: one literal table."""

from collections.abc import Callable
from enum import Enum
from typing import Final, NamedTuple

from rfms_can.conform.checks import configuring, presence, refusals
from rfms_can.conform.tester import Tester


class Kind(Enum):
    """What a check needs of the node and of what it drives."""

    BUS = "bus"
    """A bus; nothing moves."""
    SENSOR = "sensor"
    """A build that takes MEASURE and REFERENCE from the bus: its DAC follows what the tester says."""
    AXIS = "axis"
    """An axis that is free to move."""


class Check(NamedTuple):
    """One check.

    Attributes:
        id: number of the question, with a letter where it has several checks.
        title: what is done.
        want: what is required.
        kind: what it needs.
        run: asks the node; raises ``CheckFailed``. None where it is pending.
        required: whether the node must pass; else it is recommended.
        pending: why it is listed but not run.
    """

    id: str
    title: str
    want: str
    kind: Kind
    run: Callable[[Tester], None] | None
    required: bool = True
    pending: str = ""


B, S, A = Kind

# fmt: off
CHECKS: Final[tuple[Check, ...]] = (
    Check("1", "power on", "one HEARTBEAT, counter 0, PREOP, no configuration, right DBC hash; quiet",
          B, presence.power_on),
    Check("2", "NMT ANNOUNCE to all, and to the node", "HEARTBEAT, its counter one on",
          B, presence.announce),
    Check("3", "NMT to each other node", "quiet", B, presence.announce_others),
    Check("4", "counters that go on, repeat, go back, leap, on CONFIG",
          "the rule of wire.md to the digit; each refusal counts one", B, presence.counter_rule),
    Check("4b", "the same on NMT", "no exception to the rule", B, presence.counter_rule_of_nmt),
    Check("5", "each bit of each frame that it hears flipped", "quiet, discarded + 1",
          B, refusals.one_bit),
    Check("6", "a CRC of another data ID", "quiet, discarded + 1", B, refusals.another_data_id),
    Check("7", "longer, shorter and classic frames; a receiver need not look at BRS",
          "quiet, discarded + 1", B, refusals.wrong_length),
    Check("8", "each field out of its range by the least it can be, NaN, infinity, no name",
          "quiet, discarded + 1; taken at the ends of the range", B, refusals.wrong_values),
    Check("9", "frames that are for others, right and wrong ones", "quiet, discarded unchanged",
          B, refusals.for_others),
    Check("10", "the same SYNC twice", "one answer, discarded + 1", B, refusals.twice),
    Check("11", "HOME without a configuration; START, STOP, QUICKSTOP in PREOP",
          "quiet, state and counters unchanged", B, refusals.not_yet),
    Check("12", "each parameter, COMMIT; sets of both arms", "TAKEN bit for bit, the set's hash",
          B, configuring.each_parameter),
    Check("12b", "each parameter at the ends of its range, and one float32 beyond",
          "TAKEN; REFUSED_VALUE, and not kept", B, configuring.ranges),
    Check("13", "parameters without a name", "UNKNOWN, not part of the set",
          B, configuring.unknown),
    Check("14", "COMMIT with another hash or number, or with a parameter missing",
          "WRONG_HASH and the hash of what came; hash 0", B, configuring.wrong_commit),
    Check("15", "parameters in reversed order; another CLOCK and BARRIER", "TAKEN, the same hash",
          B, configuring.in_any_order),
    Check("16", "a parameter after COMMIT", "hash 0 in the next HEARTBEAT, an empty set begun",
          B, configuring.after_commit),
    Check("17", "RESET with a set in force, and with an open one", "kept; cleared",
          B, configuring.reset_and_configuration),
    Check("18", "CONFIG in HOMING, READY, OPERATIONAL, QUICKSTOP, FAULT",
          "REFUSED_STATE, nothing changed", S, configuring.refused_by_state),
    Check("19", "contradictions, geometries and sources that the node does not have",
          "REFUSED_VALUE, UNSUPPORTED; hash 0", B, configuring.impossible),
    Check("50", "SYNC of many numbers in PREOP", "HEARTBEAT with each multiple of 12, no other",
          B, presence.heartbeat_phase),
)
# fmt: on
