"""Sees a simulated system through a trial: what its nodes count and do, where its joints are.

It reads the nodes and the plant; it changes nothing, and no node knows of it.
"""

from collections.abc import Iterator
from typing import Any, Final, NamedTuple

from rfms_can.faults.facts import Facts
from rfms_can.faults.site import Site
from rfms_can.faults.table import GOAL, HARDNESS, JOINT, Variant
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.master.phases import Phase
from rfms_can.wire.emergency import in_words
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, JOINTS, MASTER, NODE_NAMES, PLANT
from rfms_can.wire.records import Emcy
from rfms_can.wire.vocabulary import NodeState

STILL: Final = 0.01
"""Speed over the limit below which a joint is at rest."""
STILL_CYCLES: Final = 10
"""Cycles in a row after which an arm is at rest."""
MOVES: Final = 0.05
"""Speed over the limit from which a brake that closes does so in motion."""
STOP_RAD: Final = 1e-6
"""Distance from its hard stop at which a joint stands on it."""
SLICES: Final = 8
"""Looks in a cycle, beside those at the end of each frame."""

_STOPPED: Final = (NodeState.QUICKSTOP, NodeState.FAULT)


class Moment(NamedTuple):
    """One cycle of a trial, for plots.

    Attributes:
        time_s: since the fault was put in, s.
        q: joint angles, rad (6).
        qd: joint speeds, rad/s (6).
        goal: commanded angles, rad (6).
        states: node states of the joints (6).
        brakes: whether each brake holds (6).
    """

    time_s: float
    q: list[float]
    qd: list[float]
    goal: list[float]
    states: list[int]
    brakes: list[bool]


class Watch:
    """Watches one trial from the instant the fault is put in.

    Args:
        site: of the fault.
        variant: of the fault.
    """

    def __init__(self, site: Site, variant: Variant) -> None:
        self._site, self._variant = site, variant
        rig, context = site.rig, site.context
        self._bus, self._master, self._plant = rig.bus, rig.master, rig.plant
        self._period_ns = context.period_ns
        # a fault of the master, or of what goes on, leaves all joints sound
        self._at_fault = context.node if variant.culprit in (JOINT, NODE_NAMES[PLANT]) else 0
        self._begun_ns = rig.bus.now_ns
        self._cycle = rig.master.cycle.number
        self._emergencies = {context.wire.codec(Emcy, n).id: n for n in (*JOINTS, GRIPPER)}
        self._counted0 = self._counts()
        self._held0 = self._holds()
        self._counted_ns: int | None = None
        self._stopped_ns: int | None = None
        self._reached_ns: int | None = None
        self._halted_ns: int | None = None
        self._halted: tuple[str, str] | None = None  # whom the master blames, and its words
        self._named = self._told = ""  # by the first EMCY
        self._hardest = [0] * len(JOINTS)
        self._enabled = False
        self._reenabled: list[str] = []
        self._brakes = self._closed()
        self._left = [False] * len(JOINTS)  # joints that have left OPERATIONAL
        self._early: set[int] = set()  # whose brake closed too early
        self._moved = _moving(rig.plant.physics.true_qd, context.arm.speed_limits)
        self._qd: list[float] | None = None
        self._speed = self._acceleration = self._past = self._following = 0.0
        self._contact = False
        self._still = 0
        self._rest_ns: int | None = None
        self.moments: list[Moment] = []
        rig.bus.observers.append(self._look)

    def finish(self) -> None:
        """Look once more: the last event may have been behind the last frame."""
        self._react()

    def run(self, cycles: int, at_least: int) -> None:
        """Let the system run for so many cycles, and look at it.

        An arm that has stopped and is at rest is looked at for ``at_least`` cycles in all.
        """
        bus, period_ns = self._bus, self._period_ns
        begun_ns = bus.now_ns
        for number in range(cycles):
            for part in range(SLICES):
                bus.run_until(begun_ns + number * period_ns + (part + 1) * period_ns // SLICES)
                self._react()
            self._sample()
            if number >= at_least and self._stopped_ns and self._still >= STILL_CYCLES:
                return

    # --- at each frame ------------------------------------------------------------------------

    def _look(self, now_ns: int, frame: Frame, _sender: str) -> None:
        node = self._emergencies.get(frame.id)
        if node is not None and not self._named:
            wire = self._site.context.wire
            emergency: Any = wire.codec(Emcy, node).unpack(frame.data)
            if emergency is not None:
                self._told = f"{NODE_NAMES[node]}: {in_words(wire, node, emergency)}"
                self._named = NODE_NAMES.get(emergency.culprit, NODE_NAMES[node])
        self._react(now_ns)

    def _react(self, now_ns: int | None = None) -> None:
        """Note what nodes count and how they react."""
        now_ns = self._bus.now_ns if now_ns is None else now_ns
        if self._counted_ns is None and self._counts() != self._counted0:
            self._counted_ns = now_ns
        fault = self._master.fault
        if fault is not None and self._halted_ns is None:
            self._halted_ns = now_ns
            culprit = self._master.culprit
            self._halted = (culprit.sender if culprit is not None else "", fault)
        for index, joint in enumerate(self._site.rig.joints):
            reaction = _reaction(joint)
            if reaction > self._hardest[index]:
                self._hardest[index] = reaction
                if reaction >= Reaction.STOP and self._stopped_ns is None:
                    self._stopped_ns = now_ns
            self._see_state(index, joint.state)
        self._see_short_stop(now_ns)
        if self._reached_ns is None and self._is_reached():
            self._reached_ns = now_ns

    def _see_short_stop(self, now_ns: int) -> None:
        """A stop by the trajectory: the arm cannot follow, and no node has to do anything."""
        why = self._master.motion.stopped_short
        if why is None or self._stopped_ns is not None:
            return
        self._stopped_ns = now_ns
        self._hardest = [max(r, int(Reaction.STOP)) for r in self._hardest]
        if not self._named:
            self._told = f"stopped short: {why}"
            self._named = GOAL if "reference" in why else NODE_NAMES[MASTER]

    def _see_state(self, index: int, state: NodeState) -> None:
        if state is NodeState.OPERATIONAL:
            self._enabled = True
            if self._left[index]:
                self._note(f"joint {index + 1} was enabled again")
        elif state in _STOPPED:
            self._left[index] = True

    def _note(self, words: str) -> None:
        if words not in self._reenabled:
            self._reenabled.append(words)

    def _is_reached(self) -> bool:
        """Whether the reaction that the row asks for is there, where it asks for it first."""
        wanted = HARDNESS[self._variant.expected]
        if wanted > Reaction.STOP and self._variant.culprit == JOINT:
            return self._hardest[self._site.context.index] >= wanted
        return max(self._hardest) >= wanted

    def _sound(self) -> Iterator[int]:
        """Reactions of the joints that are not at fault."""
        return (r for n, r in zip(JOINTS, self._hardest, strict=True) if n != self._at_fault)

    def _nodes(self) -> Iterator[Any]:
        rig = self._site.rig
        yield from (*rig.joints, rig.gripper, rig.plant, rig.master)

    def _counts(self) -> int:
        """Everything that nodes have counted."""
        counted: int = self._master.statistics.incomplete + sum(
            node.discarded
            + node.foreign
            + node.lost
            + sum(node.ignored.values())
            + sum(getattr(node, "faults", {}).values())
            for node in self._nodes()
        )
        return counted

    def _holds(self) -> int:
        """How often a node has held its last set-point, or the master has gone on without all."""
        return self._master.statistics.incomplete + sum(
            sum(getattr(node, "faults", {}).values()) for node in self._nodes()
        )

    # --- once a cycle -------------------------------------------------------------------------

    def _closed(self) -> list[bool]:
        return [self._plant.braked(index) for index in range(len(JOINTS))]

    def _sample(self) -> None:
        """Where the joints are, and how fast."""
        physics, arm = self._plant.physics, self._site.context.arm
        q, qd, goal = physics.true_q, physics.true_qd, self._master.motion.commanded.theta
        self._see_motion(qd, arm.speed_limits, arm.acceleration_limits)
        for angle, (lower, upper) in zip(q, arm.joint_limits, strict=True):
            self._past = max(self._past, lower - angle, angle - upper)
        for angle, (lower, upper) in zip(q, arm.hard_stops, strict=True):
            self._contact |= angle < lower + STOP_RAD or angle > upper - STOP_RAD
        if self._master.phase is Phase.RUN:
            off = max(abs(a - b) for a, b in zip(q, goal, strict=True))
            self._following = max(self._following, off)
        self._see_brakes(qd, arm.speed_limits)
        self.moments.append(
            Moment(
                (self._bus.now_ns - self._begun_ns) * 1e-9,
                *(q, qd, list(goal)),
                [int(joint.state) for joint in self._site.rig.joints],
                list(self._brakes),
            )
        )

    def _see_motion(
        self, qd: list[float], speeds: tuple[float, ...], most: tuple[float, ...]
    ) -> None:
        fastest = max(abs(v) / limit for v, limit in zip(qd, speeds, strict=True))
        self._speed = max(self._speed, fastest)
        if self._qd is not None:
            period_s = self._period_ns * 1e-9
            changes = (abs(a - b) / period_s for a, b in zip(qd, self._qd, strict=True))
            of_limit = (a / limit for a, limit in zip(changes, most, strict=True))
            self._acceleration = max(self._acceleration, *of_limit)
        self._qd = qd
        if fastest > STILL:
            self._still, self._rest_ns = 0, None
        else:
            self._still += 1
            if self._still == 1:
                self._rest_ns = self._bus.now_ns

    def _see_brakes(self, qd: list[float], speeds: tuple[float, ...]) -> None:
        closed = self._closed()
        for index, (before, now) in enumerate(zip(self._brakes, closed, strict=True)):
            joint = index + 1
            if before and not now and self._left[index]:
                self._note(f"the brake of joint {joint} opened again")
            sound = joint != self._at_fault and self._hardest[index] < Reaction.OFF
            if now and not before and sound and self._moved[index]:
                self._early.add(joint)
        self._brakes = closed
        self._moved = _moving(qd, speeds)

    # --- at the end ---------------------------------------------------------------------------

    @property
    def _ended_badly(self) -> bool:
        """Whether a run ends with an error: a fault, or a program that is told of a short stop."""
        master = self._master
        return master.fault is not None or master.motion.stopped_short is not None

    def facts(self) -> Facts:
        """What was measured."""
        effect_ns = self._site.effect_ns
        site, period_ns = self._site, self._period_ns

        def since(at_ns: int | None) -> float | None:
            if at_ns is None:
                return None
            if effect_ns is None:
                return 0.0  # found before it had an effect
            return round((at_ns - effect_ns) / period_ns, 2)

        named, told = self._halted or (self._named, self._told)
        hung = getattr(site.controller(MASTER).node, "hung", False)
        return Facts(
            node=site.context.node,
            injected=self._cycle,
            effect=None
            if effect_ns is None
            else round((effect_ns - self._begun_ns) / period_ns, 2),
            counted=since(self._counted_ns),
            stopped=since(self._stopped_ns),
            reached=since(self._reached_ns),
            halted=since(self._halted_ns),
            reactions=list(self._hardest),
            others=min(self._sound()),
            held=self._holds() != self._held0,
            named=named,
            told=told,
            speed=round(self._speed, 3),
            acceleration=round(self._acceleration, 2),
            past_range=round(self._past, 4),
            contact=self._contact,
            brakes=sorted(self._early),
            following=round(self._following, 5),
            reenabled=self._reenabled,
            rest=since(self._rest_ns) if self._still >= STILL_CYCLES else None,
            refused=site.refused,
            enabled=self._enabled,
            exit_code=int(self._ended_badly or hung),
        )


def _reaction(joint: Any) -> Reaction:
    """How hard a joint has reacted: by its ladder, or since it was told to stop."""
    told = Reaction.STOP if joint.state in _STOPPED else Reaction.NONE
    return max(told, Reaction(joint.reaction))


def _moving(qd: list[float], speeds: tuple[float, ...]) -> list[bool]:
    return [abs(v) > MOVES * limit for v, limit in zip(qd, speeds, strict=True)]
