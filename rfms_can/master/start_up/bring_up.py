"""From power-up to configured nodes: roll call by heartbeats, then one dialogue with each node."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

from rfms_can.master.arm_state import ArmState
from rfms_can.master.fault import Fault
from rfms_can.master.start_up.configurator import Configurator
from rfms_can.master.start_up.roster import EXPECTED, Roster
from rfms_can.messages.culprit import Culprit
from rfms_can.wire.configuration import plant_hash
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import HEARTBEAT_EVERY, JOINTS, NODE_NAMES, PLANT
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import Config, ConfigAck
from rfms_can.wire.vocabulary import Command, NodeState, Parameter

RETRY_NS: Final = 500_000_000
"""Time between two calls, ns."""
RESET_PATIENCE_NS: Final = 5_000_000_000
"""Time for a node to answer after a fault, ns: a person waits for it."""
INTRODUCTION_NS: Final = 10_000_000
"""Time for a HEARTBEAT to go out on a bus that others fill, ns."""

HOMING_PATIENCE: Final = 1.5
"""Time for homing over the longest HOMING_TIME of a node, which gives up by itself before."""


class BringUp:
    """Who is there, and whether each holds its configuration.

    Args:
        wire: compiled codecs.
        parameters: configuration of nodes 1 to 7.
        patience_s: how long a silent node is waited for, s.
        nmt: the master's sender of NMT.

    Attributes:
        roster: the last heartbeat of every node.
        senders: of CONFIG frames.
        problem: why the bus cannot be brought up, or None.
        unreferenced: nodes that were configured in this bring-up, and do not know where they are.
        homing_cycles: cycles in which all must be homed.
    """

    def __init__(
        self,
        wire: Wire,
        parameters: Mapping[int, Mapping[Parameter, float]],
        patience_s: float,
        nmt: Sender[Any],
    ) -> None:
        joint = parameters[JOINTS[0]]
        self.homing_cycles: Final = _homing_cycles(parameters)
        plant = plant_hash(joint[Parameter.ARM_ID], joint[Parameter.PERIOD])
        self.roster = Roster(wire.dbc_hash, plant)
        self.problem: str | None = None
        self.unreferenced: frozenset[int] = frozenset(parameters)
        self.senders: list[Sender[Any]] = [wire.sender(Config, node) for node in parameters]
        self._settings = {
            node: (values, sender)
            for (node, values), sender in zip(parameters.items(), self.senders, strict=True)
        }
        self._dialogues = {
            node: Configurator(node, *settings) for node, settings in self._settings.items()
        }
        self._nmt = nmt
        self._patience_ns = round(patience_s * 1e9)
        self._until_ns: int | None = None
        self._configuring = False
        self._calls = 0

    @property
    def introducing(self) -> bool:
        """Whether the master only tells that it is there; commands follow with the next call."""
        return self._calls <= 1

    @property
    def retry_ns(self) -> int:
        """Time until the next call, ns."""
        return INTRODUCTION_NS if self.introducing else RETRY_NS

    @property
    def all_present(self) -> bool:
        """Whether every node has announced itself, and has taken the reset."""
        if self.introducing or self.roster.absent():
            return False
        return self.roster.all_in(NodeState.PREOP)

    def call(self, now_ns: int) -> Sequence[Frame]:
        """Ask those who are silent, again; in vain for too long is a problem.

        The first call asks nothing: the master's HEARTBEAT goes out alone. Its boot id tells nodes
        that counted the frames of an earlier master to take the commands that come next, and a
        HEARTBEAT is the least urgent of all frames: beside a command it would come after it.
        """
        self._calls += 1
        if self._until_ns is None:
            self._until_ns = now_ns + self._patience_ns
        if self.introducing:
            return ()
        if now_ns >= self._until_ns:
            self.problem = self._whom_we_wait_for()
            return ()
        if not self._configuring:
            # a joint that still drives for a master that was killed takes RESET once it has stopped
            return [self._nmt.frame(c, 0, 0) for c in (Command.RESET, Command.ANNOUNCE)]
        return [d.current() for d in self._dialogues.values() if not d.done]

    def restart(self) -> None:
        """Call all nodes again, after a fault; they know this master, and who is there answers.

        A node that still holds its configuration, and with it its reference, keeps both, unless the
        plant has started again, whose encoders then count from elsewhere.
        """
        self.problem = None
        self._until_ns = None
        self._patience_ns = min(self._patience_ns, RESET_PATIENCE_NS)
        self._configuring = False
        self._calls = 1
        self.roster.forget()

    def _whom_we_wait_for(self) -> str:
        if not self._configuring:
            absent = ", ".join(self.roster.absent())
            if absent:
                return f"not on the bus: {absent}; start them, or look at their own error messages"
            busy = ", ".join(self.roster.not_in(NodeState.PREOP))
            return f"RESET is not taken by {busy}; does another master run on this bus?"
        silent = ", ".join(NODE_NAMES[n] for n, d in self._dialogues.items() if not d.done)
        return f"no answer to CONFIG from {silent}"

    @property
    def suspect(self) -> int:
        """Number of the first node that is waited for; 0 if there is none."""
        waiting = [n for n in EXPECTED if n not in self.roster.beats]
        if not self._configuring:
            waiting += [n for n, b in self.roster.beats.items() if b.state != NodeState.PREOP]
        waiting += [n for n, d in self._dialogues.items() if d.problem or not d.done]
        return waiting[0] if waiting else 0

    def fault(self, besides: str = "") -> Fault | None:
        """Why the bus cannot be brought up, or None.

        Args:
            besides: what else is known.
        """
        if self.problem is None:
            return None
        refusing = [n for n, d in self._dialogues.items() if d.problem]
        node = refusing[0] if refusing else self.suspect
        message = "CONFIG_ACK" if self._configuring else "HEARTBEAT"
        frame = f"{message}_{node}" if node else ""
        return Fault(f"{self.problem}{besides}", Culprit(NODE_NAMES.get(node, ""), frame))

    def configure(self, now_ns: int) -> Sequence[Frame]:
        """All are present: open a dialogue with each that does not hold its configuration."""
        self._configuring = True
        same_plant = self.roster.same_boot(PLANT)
        lost = [n for n, d in self._dialogues.items() if not (same_plant and self._holds(n, d))]
        self._dialogues |= {node: Configurator(node, *self._settings[node]) for node in lost}
        self.unreferenced = frozenset(lost)
        self._until_ns = now_ns + self._patience_ns
        return [self._dialogues[node].current() for node in lost]

    def _holds(self, node: int, dialogue: Configurator) -> bool:
        """Whether a node still has the configuration it confirmed to this master."""
        beat = self.roster.beats[node]
        return dialogue.done and self.roster.same_boot(node) and beat.config_hash == dialogue.hash

    def acknowledge(self, node: int, ack: ConfigAck) -> Sequence[Frame]:
        """Take a node's acknowledgement; the next frame for it."""
        dialogue = self._dialogues[node]
        following = dialogue.acknowledge(ack)
        if dialogue.problem:
            self.problem = dialogue.problem
        return () if following is None else (following,)

    def hold_to_configuration(self) -> Fault | None:
        """From now on every HEARTBEAT must carry the hash that its node has confirmed.

        Returns:
            What is wrong with the last one of a node, or None.
        """
        self.roster.configured = {node: d.hash for node, d in self._dialogues.items()}
        for node in self._dialogues:
            words = self.roster.misconfigured(node)
            if words is not None:
                return heartbeat_fault(self.roster, node, words)
        return None

    def homing_overdue(self, arm_state: ArmState) -> Fault:
        """Why homing has not ended in its time."""
        late = self.roster.not_in(NodeState.READY)
        frame = "HEARTBEAT"
        if not late:
            unknown = zip(JOINTS, arm_state.zeros_known, strict=True)
            late = [f"joint {n} (no index in REFERENCE_{n})" for n, known in unknown if not known]
            frame = "REFERENCE"
        sender = late[0].partition(" (")[0]
        number = next(n for n, name in NODE_NAMES.items() if name == sender)
        bound = float(self.homing_cycles)
        return Fault(
            f"not READY after {self.homing_cycles} cycles of homing: {', '.join(late)}; each node "
            f"must home, or tell HOMING_FAILED, within its HOMING_TIME",
            Culprit(sender, f"{frame}_{number}", None, bound + 1.0, bound),
        )

    @property
    def configured(self) -> bool:
        """Whether every node has confirmed its configuration."""
        return all(dialogue.done for dialogue in self._dialogues.values())


def heartbeat_fault(roster: Roster, node: int, words: str) -> Fault:
    """What is wrong with a node's last heartbeat."""
    value, bound = roster.numbers(node)
    frame = f"HEARTBEAT_{node}"
    return Fault(words, Culprit(NODE_NAMES[node], frame, None, value, bound))


def _homing_cycles(parameters: Mapping[int, Mapping[Parameter, float]]) -> int:
    """Cycles in which all nodes must be homed; a HEARTBEAT tells it only every so often."""
    longest = max(p[Parameter.HOMING_TIME] / p[Parameter.PERIOD] for p in parameters.values())
    return math.ceil(HOMING_PATIENCE * longest) + 2 * HEARTBEAT_EVERY
