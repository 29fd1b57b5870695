"""What a stranger on the bus has seen of a fault, as the facts that the judge reads.

Nothing is asked of any node: reactions are those that EMCY, QUICKSTOP and MEASURE tell, motion is
that of the encoders. A cycle is the longest one (the barrier): a cycle without a fault is shorter.
"""

from collections.abc import Callable
from typing import Any, Final

from rfms_can.arm import Arm
from rfms_can.faults.facts import Facts
from rfms_can.faults.processes.joints import Joints
from rfms_can.faults.processes.tape import Heard
from rfms_can.faults.table import HARDNESS, JOINT, Variant
from rfms_can.joint_nodes.ladder import LADDERS, Reaction
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.emergency import in_words
from rfms_can.wire.nodes import JOINTS, NODE_NAMES, PLANT
from rfms_can.wire.records import Dac, Emcy, Estop, Heartbeat, Measure, Nmt, Sync
from rfms_can.wire.vocabulary import Command, FaultCode, NodeState

MOVES: Final = 0.05
"""Speed over the limit from which a brake that closes does so in motion."""
STILL_PERIODS: Final = 4
"""Periods in a row after which an arm is at rest; without SYNC each of them takes a cycle."""
SETTLED: Final = 2.0
"""Cycles after the stop from which on no node may say OPERATIONAL, and after its brake has closed
from which on it may not ask for torque: what was under way is over then."""
_STOPPED: Final = (NodeState.QUICKSTOP, NodeState.FAULT)
_EVERYONE: Final = 0


def reaction_told(emergency: Emcy) -> Reaction:
    """How hard a node reacts that sends an emergency: its bound is the rung that was reached."""
    steps = LADDERS.get(FaultCode(emergency.fault), ()) if emergency.fault in _CODES else ()
    if len(steps) == 1:
        return steps[0][1]
    return next((r for cycles, r in steps if cycles == emergency.bound), Reaction.STOP)


_CODES: Final = frozenset(FaultCode)


class Evidence:
    """Takes in what is heard from the fault on.

    Args:
        wire: codecs.
        arm: the arm's data.
        joints: as they were when the fault was put in.
        variant: of the fault.
        node: number of the node at fault.
        effect_ns: when the fault began to show.
        cycle_ns: length of the longest cycle.
        back_ns: when the node at fault was let go on, or was started again; None if it was not.
    """

    def __init__(
        self,
        wire: Wire,
        arm: Arm,
        joints: Joints,
        variant: Variant,
        node: int,
        effect_ns: int,
        cycle_ns: int,
        back_ns: int | None = None,
    ) -> None:
        self._wire, self._arm, self._joints = wire, arm, joints
        self._variant, self._node = variant, node
        self._effect_ns, self._cycle_ns, self._back_ns = effect_ns, cycle_ns, back_ns
        self._at_fault = node if variant.culprit in (JOINT, NODE_NAMES[PLANT]) else 0
        self._hardest = [Reaction.NONE] * len(JOINTS)
        self._first = ""  # emergency of a node, in words
        self._first_culprit = ""
        self._stopped_ns: int | None = None
        self._reached_ns: int | None = None
        self._told_ns: int | None = None  # the master's own stop
        self._brakes = list(joints.braked)
        self._closed_ns: list[int | None] = [None] * len(JOINTS)  # since the fault
        self._moved = [False] * len(JOINTS)
        self._early: set[int] = set()
        self._reenabled: list[str] = []
        self._speed = 0.0
        self._rest_ns: int | None = None
        self._enabled = False

    def take(self, heard: Heard) -> None:
        """A frame."""
        reader = _READERS.get(type(heard.values))
        if reader is not None:
            reader(self, heard.at_ns, heard.node, heard.values)

    # --- frames -------------------------------------------------------------------------------

    def _emergency(self, at_ns: int, node: int, emergency: Emcy) -> None:
        reaction = reaction_told(emergency)
        if node in JOINTS:
            self._reacts(at_ns, node, reaction)
        if reaction >= Reaction.STOP and not self._first and self._told_ns is None:
            self._first = f"{NODE_NAMES[node]}: {in_words(self._wire, node, emergency)}"
            self._first_culprit = NODE_NAMES.get(emergency.culprit, NODE_NAMES[node])

    def _command(self, at_ns: int, _: int, nmt: Nmt) -> None:
        if nmt.command == Command.QUICKSTOP:
            self._all_react(at_ns, Reaction.STOP, nmt.node)

    def _emergency_stop(self, at_ns: int, _: int, estop: Estop) -> None:
        if estop == ESTOP_VALUES:
            self._all_react(at_ns, Reaction.OFF, _EVERYONE)

    def _sync(self, at_ns: int, _: int, sync: Sync) -> None:
        if sync.state in _STOPPED:
            self._all_react(at_ns, Reaction.STOP, _EVERYONE)

    def _heartbeat(self, at_ns: int, node: int, beat: Heartbeat) -> None:
        if node not in JOINTS:
            return
        if beat.state in _STOPPED:
            self._reacts(at_ns, node, Reaction.STOP)
        elif beat.state == NodeState.OPERATIONAL:
            self._enabled = True
            if self._over(at_ns, node):
                self._note(f"joint {node} says OPERATIONAL after the stop")

    def _dac(self, at_ns: int, node: int, dac: Dac) -> None:
        closed_ns = self._closed_ns[node - 1]
        late = closed_ns is not None and at_ns > closed_ns + SETTLED * self._cycle_ns
        if late and self._over(at_ns, node) and (dac.current_dac or dac.force_dac):
            self._note(f"joint {node} asks for torque after its brake has closed")

    def _measure(self, at_ns: int, node: int, measure: Measure) -> None:
        index = node - 1
        self._joints.take(index, measure)
        speed = abs(self._joints.speeds[index])
        self._speed = max(self._speed, speed)
        self._see_brake(at_ns, index, bool(measure.braked))
        self._moved[index] = speed > MOVES
        if node == JOINTS[-1]:
            still = self._joints.at_rest(STILL_PERIODS)
            self._rest_ns = (self._rest_ns or at_ns) if still else None

    def _see_brake(self, at_ns: int, index: int, closed: bool) -> None:
        joint = index + 1
        if closed and not self._brakes[index]:
            self._closed_ns[index] = at_ns
            if joint == self._at_fault:
                self._reacts(at_ns, joint, Reaction.OFF)
            elif self._hardest[index] < Reaction.OFF and self._moved[index]:
                self._early.add(joint)
        elif self._brakes[index] and not closed:
            self._note(f"the brake of joint {joint} opened again")
        self._brakes[index] = closed

    # --- what they mean -----------------------------------------------------------------------

    def _all_react(self, at_ns: int, reaction: Reaction, node: int) -> None:
        self._told_ns = self._told_ns or at_ns
        for joint in JOINTS:
            if node in (_EVERYONE, joint) and joint != self._at_fault:
                self._reacts(at_ns, joint, reaction)

    def _reacts(self, at_ns: int, joint: int, reaction: Reaction) -> None:
        self._hardest[joint - 1] = max(self._hardest[joint - 1], reaction)
        if reaction >= Reaction.STOP and self._stopped_ns is None:
            self._stopped_ns = at_ns
        if self._reached_ns is None and self._is_reached():
            self._reached_ns = at_ns

    def _is_reached(self) -> bool:
        wanted = HARDNESS[self._variant.expected]
        if wanted > Reaction.STOP and self._variant.culprit == JOINT:
            return self._hardest[self._node - 1] >= wanted
        return max(self._hardest) >= wanted

    def _over(self, at_ns: int, node: int) -> bool:
        """Whether the stop was so long ago that nothing of before is under way any more.

        A process that goes on has the frames of its sleep before it, and answers them first.
        """
        last_ns = self._stopped_ns
        if last_ns is not None and node == self._at_fault and self._back_ns is not None:
            last_ns = max(last_ns, self._back_ns)
        return last_ns is not None and at_ns > last_ns + SETTLED * self._cycle_ns

    def _note(self, words: str) -> None:
        if words not in self._reenabled:
            self._reenabled.append(words)

    # --- at the end ---------------------------------------------------------------------------

    def at_rest_since(self) -> int | None:
        """When the arm came to rest; without a plant, when the last torque was taken off."""
        if self._node == PLANT:
            return self._reached_ns
        return self._rest_ns

    def facts(self, **others: Any) -> Facts:
        """What was seen; ``others`` are the facts that the bus does not tell."""

        def since(at_ns: int | None) -> float | None:
            return None if at_ns is None else round((at_ns - self._effect_ns) / self._cycle_ns, 2)

        sound = (r for n, r in zip(JOINTS, self._hardest, strict=True) if n != self._at_fault)
        told = {"named": self._first_culprit, "told": self._first} if self._first else {}
        values: dict[str, Any] = {
            "node": self._node,
            "effect": 0.0,
            "stopped": since(self._stopped_ns),
            "reached": since(self._reached_ns),
            "halted": since(self._told_ns),
            "reactions": [int(reaction) for reaction in self._hardest],
            "others": int(min(sound)),
            "speed": round(self._speed, 3),
            "brakes": sorted(self._early),
            "reenabled": self._reenabled,
            "rest": since(self.at_rest_since()),
            "enabled": self._enabled,
        }
        return Facts(**{**values, **others, **told})


_READERS: Final[dict[type[Any], Callable[[Evidence, int, int, Any], None]]] = {
    Emcy: Evidence._emergency,
    Nmt: Evidence._command,
    Estop: Evidence._emergency_stop,
    Sync: Evidence._sync,
    Heartbeat: Evidence._heartbeat,
    Dac: Evidence._dac,
    Measure: Evidence._measure,
}
