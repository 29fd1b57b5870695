"""When a fault of a process began to show on the bus."""

from collections.abc import Callable, Iterator
from typing import Any, Final, NamedTuple

from rfms_can.faults.processes.injectors import Shows
from rfms_can.faults.processes.tape import Heard
from rfms_can.tables import complete
from rfms_can.wire.nodes import MASTER, PLANT
from rfms_can.wire.records import Dac, Heartbeat, Measure, Sync


class Scene(NamedTuple):
    """What was heard of a fault.

    Attributes:
        before, after: it was put in.
        at_ns: when that was.
    """

    before: list[Heard]
    after: list[Heard]
    at_ns: int


_SENDS: Final[dict[int, tuple[type[Any], int]]] = {MASTER: (Sync, 0), PLANT: (Measure, 1)}
"""A message that a node sends in each cycle, and whose number it has; of a joint it is its DAC."""


def _silence(when: Scene, node: int, cycle_ns: int) -> int | None:
    """A SYNC is due a longest cycle after the last one; another frame, at the next SYNC."""
    record, number = _SENDS.get(node, (Dac, node))
    frames = [*when.before, *when.after]
    last = max(_until_pause(when, record, number, cycle_ns), default=frames[0].at_ns)
    if record is Sync:
        return last + cycle_ns
    syncs = (h.at_ns for h in frames if isinstance(h.values, Sync) and h.at_ns > last)
    return next(syncs, last)


def _until_pause(when: Scene, record: type[Any], number: int, cycle_ns: int) -> Iterator[int]:
    """Times of a node's frames up to its first silence of a whole cycle: it may come back.

    Not a silence before the fault: there it was the machine that was slow.
    """
    last: int | None = None
    for heard in (*when.before, *when.after):
        if not isinstance(heard.values, record) or heard.node != number:
            continue
        silent_since = max(when.at_ns, heard.at_ns if last is None else last)
        if heard.at_ns > silent_since + cycle_ns:
            return
        last = heard.at_ns
        yield last


def _intrusion(when: Scene, node: int, _: int) -> int | None:
    """The first heartbeat with another boot id than the node's."""
    known = {
        h.values.boot_id for h in when.before if isinstance(h.values, Heartbeat) and h.node == node
    }
    others = (
        h.at_ns
        for h in when.after
        if isinstance(h.values, Heartbeat) and h.node == node and h.values.boot_id not in known
    )
    return next(others, None) if known else None


def _at_once(when: Scene, _: int, __: int) -> int | None:
    return when.at_ns


_Finder = Callable[[Scene, int, int], int | None]
_FINDERS: Final[dict[Shows, _Finder]] = complete(
    {Shows.SILENCE: _silence, Shows.INTRUSION: _intrusion, Shows.AT_ONCE: _at_once}, Shows
)


def effect_ns(shows: Shows, when: Scene, node: int, cycle_ns: int) -> int | None:
    """When a fault began to show; None if it never did.

    Args:
        shows: how.
        when: what was heard.
        node: number of the node at fault.
        cycle_ns: length of the longest cycle.
    """
    return _FINDERS[shows](when, node, cycle_ns)
