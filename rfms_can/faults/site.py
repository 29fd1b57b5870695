"""Where a fault is put into a simulated system: its bus, its nodes, its boards, its program."""

from collections.abc import Callable
from typing import Final

from rfms_can.bus.controller import Controller
from rfms_can.coordinator import Arm as Program
from rfms_can.errors import RfmsError
from rfms_can.faults.context import Context
from rfms_can.faults.tap import Tap
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.frame import Frame

MOTION_FLOOR: Final = 0.125
"""Error of a joint's speed over its limit, up to which it moves as sound joints do: what they leave
at full speed with friction half as much again as they know."""


class Site:
    """A simulated system that a fault is put into.

    Args:
        rig: the system.
        context: of the fault; its ``touch`` is this site's.
        program: the program API of the arm; None where no program may ask.
        goal, mode: names of a position and a mode that the program's moves have.

    Attributes:
        effect_ns: when the fault had its first effect; None before.
        refused: why a request of the program was refused; None if it asked for nothing.
    """

    def __init__(
        self,
        rig: SimulatedRig,
        context: Context,
        program: Program | None = None,
        goal: str = "",
        mode: str = "",
    ) -> None:
        self.rig = rig
        self.context = context
        self.goal, self.mode = goal, mode
        self.effect_ns: int | None = None
        self.refused: str | None = None
        self._program = program
        self._taps: dict[int, Tap] = {}
        self._soon: list[tuple[int, Callable[[], None]]] = []
        self._watching = False
        context.touch = self.touch

    @property
    def program(self) -> Program:
        """The program API of the arm.

        Raises:
            RfmsError: no program may ask for anything here.
        """
        if self._program is None:
            raise RfmsError("a fault of a program's requests needs rfms faults, not rfms run")
        return self._program

    def touch(self, at_ns: int | None = None) -> None:
        """The fault has its first effect, now or at an instant (ns)."""
        if self.effect_ns is None:
            self.effect_ns = self.rig.bus.now_ns if at_ns is None else at_ns

    def touch_at_loss(self, controller: Controller) -> None:
        """The first effect is the first frame that a controller's queue does not take."""
        before = controller.tx_overflow
        self.touch_when(lambda: controller.tx_overflow != before)

    def touch_at_frame_of(self, name: str) -> None:
        """The first effect is the end of the first frame of a sender."""

        def look(_: int, __: Frame, sender: str) -> None:
            if sender == name:
                self.touch()

        self.rig.bus.observers.append(look)

    def touch_when(self, condition: Callable[[], bool]) -> None:
        """The first effect is when a condition holds, at the end of a frame."""

        def look(_: int, __: Frame, ___: str) -> None:
            if condition():
                self.touch()

        self.rig.bus.observers.append(look)

    def strays(self) -> bool:
        """Whether the joint at fault moves otherwise than sound joints do."""
        index, rig = self.context.index, self.rig
        off = rig.plant.physics.true_qd[index] - rig.master.motion.commanded.rate[index]
        return abs(off) > MOTION_FLOOR * self.context.speed_limit

    def later(self, delay_ns: int, action: Callable[[], None]) -> None:
        """Do something by so much later, at the end of the next frame."""
        until_ns = self.rig.bus.now_ns + delay_ns
        self._soon.append((until_ns, action))
        self._watch()

    def _watch(self) -> None:
        if self._watching:
            return
        self._watching = True

        def look(now_ns: int, _: Frame, __: str) -> None:
            due = [action for at_ns, action in self._soon if at_ns <= now_ns]
            self._soon = [(at_ns, action) for at_ns, action in self._soon if at_ns > now_ns]
            for action in due:
                action()

        self.rig.bus.observers.append(look)

    def controller(self, node: int) -> Controller:
        """The controller of a node."""
        return self.rig.controllers[node]

    def tap(self, node: int) -> Tap:
        """The tap at a node; put there when it is first asked for."""
        if node not in self._taps:
            controller = self.controller(node)
            self._taps[node] = tap = Tap(controller.node)
            self.rig.bus.exchange(controller, tap)
        return self._taps[node]
