"""Who is on the bus and how it is, from heartbeats: presence, states, DBC and configuration."""

from typing import Final

from rfms_can.node.port_counts import PortCounts
from rfms_can.wire.nodes import GRIPPER, JOINTS, NODE_NAMES, PLANT
from rfms_can.wire.records import Heartbeat
from rfms_can.wire.vocabulary import NodeState, name_of

EXPECTED: Final = (*JOINTS, GRIPPER, PLANT)
SERVOS: Final = (*JOINTS, GRIPPER)


class Roster:
    """The last heartbeat of every node.

    Args:
        dbc_hash: what every node must run.
        plant: what the plant must be (``plant_hash``).

    Attributes:
        beats: last heartbeat by node.
        configured: hash that each node has confirmed, once the bus is configured.
    """

    __slots__ = ("_boots", "_boots_before", "_dbc_hash", "_plant", "beats", "configured")

    def __init__(self, dbc_hash: int, plant: int) -> None:
        self.beats: dict[int, Heartbeat] = {}
        self.configured: dict[int, int] = {}
        self._boots: dict[int, int] = {}
        self._boots_before: dict[int, int] = {}
        self._dbc_hash = dbc_hash
        self._plant = plant

    def forget(self) -> None:
        """A reset: every node must be heard again, and may have started again since."""
        self.beats, self.configured = {}, {}
        self._boots, self._boots_before = {}, self._boots

    def same_boot(self, node: int) -> bool:
        """Whether a node has not started again since before the reset; False at the first start."""
        boot = self._boots.get(node)
        return boot is not None and boot == self._boots_before.get(node)

    def hear(self, node: int, beat: Heartbeat) -> str | None:
        """Take a heartbeat; returns what is wrong with it, or None."""
        self.beats[node] = beat
        name = NODE_NAMES[node]
        if beat.dbc_hash != self._dbc_hash:
            return (
                f"{name} runs another DBC (hash {beat.dbc_hash:#06x}, "
                f"the master's is {self._dbc_hash:#06x}); give all nodes the same rfms.dbc"
            )
        if node == PLANT and beat.config_hash not in (0, self._plant):
            return (
                f"{name} carries another arm, or runs at another rate than the master "
                f"(configuration {beat.config_hash:#06x}, not {self._plant:#06x}); "
                f"give both the same --arm and --rate"
            )
        boot = self._boots.setdefault(node, beat.boot_id)
        if boot != beat.boot_id:
            return f"{name} restarted while the bus was up (boot id {beat.boot_id:#x}); reset"
        return self.misconfigured(node)

    def numbers(self, node: int) -> tuple[float, float | None]:
        """Of what is wrong with a node's last heartbeat, the number that it tells and its bound."""
        beat, confirmed = self.beats[node], self.configured.get(node)
        if beat.dbc_hash != self._dbc_hash:
            return beat.dbc_hash, self._dbc_hash
        if node == PLANT and beat.config_hash not in (0, self._plant):
            return beat.config_hash, self._plant
        if self._boots[node] != beat.boot_id:
            return beat.boot_id, self._boots[node]
        if confirmed is not None and beat.config_hash != confirmed:
            return beat.config_hash, confirmed
        return beat.state, None

    def misconfigured(self, node: int) -> str | None:
        """Why the configuration a node tells of is not the one it has confirmed; None if it is."""
        expected, beat = self.configured.get(node), self.beats.get(node)
        if expected is None or beat is None or beat.config_hash == expected:
            return None
        return (
            f"{NODE_NAMES[node]} holds configuration {beat.config_hash:#06x}, not "
            f"{expected:#06x}, which it has confirmed"
        )

    def absent(self) -> list[str]:
        """Names of nodes that have not been heard of."""
        return [NODE_NAMES[n] for n in EXPECTED if n not in self.beats]

    def all_in(self, state: NodeState) -> bool:
        """Whether every joint and the gripper last reported ``state``."""
        return all(n in self.beats and self.beats[n].state == state for n in SERVOS)

    def not_in(self, state: NodeState) -> list[str]:
        """Joints and gripper that last reported another state, each with it."""
        beats = [(NODE_NAMES[n], self.beats[n].state) for n in SERVOS if n in self.beats]
        return [f"{name} ({name_of(NodeState, now)})" for name, now in beats if now != state]

    def discarded(self) -> dict[str, int]:
        """Frames each node has discarded since its start."""
        return {NODE_NAMES[n]: beat.discarded for n, beat in sorted(self.beats.items())}

    def ports(self) -> dict[str, PortCounts]:
        """What each node's port has counted; the largest that a heartbeat carries stand for more.

        Those of our nodes tell it that say so (``PortTellingEndpoint``); others may.
        """
        return {
            NODE_NAMES[n]: PortCounts(beat.bus_offs, beat.overflows)
            for n, beat in sorted(self.beats.items())
        }
