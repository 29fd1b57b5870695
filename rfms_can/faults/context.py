"""What an injector is told, and where it may put its fault: the seams of a whole system."""

import random
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from rfms_can.arm import Arm, friction_set
from rfms_can.faults.forge import Forge
from rfms_can.plant.faulty_board import TORQUE_FLOOR_CODES, torque_floor
from rfms_can.wire.contract import Wire


class Seam(Enum):
    """Where a fault is put in; the value is what the documentation calls it."""

    BUS = "frames on the bus"
    TAP = "what a node hears or sends"
    BOARD = "the board of a joint"
    RIG = "nodes and their controllers"
    PROGRAM = "what a program asks for"


ANYWHERE = frozenset((Seam.TAP, Seam.BOARD))
"""Seams that are inside one process, and so there on every bus; the others need bus ``sim``."""


@dataclass(slots=True)
class Context:
    """What an injector is told.

    Attributes:
        arm: the arm's data.
        period_ns: of the control cycle.
        wire: compiled codecs.
        forge: makes frames of others.
        draw: random numbers of the trial.
        node: number of the node that is to be at fault.
        now_ns: tells the time.
        touch: called when the fault has its first effect; with the instant, ns, if it is not now.
        friction: name of the arm's friction set; empty where it is not known.
    """

    arm: Arm
    period_ns: int
    wire: Wire
    forge: Forge
    draw: random.Random
    node: int
    now_ns: Callable[[], int]
    touch: Callable[..., None]
    friction: str = ""

    @property
    def index(self) -> int:
        """Index, 0 to 5, of the joint that is to be at fault."""
        return self.node - 1

    def counts(self, angle: float) -> int:
        """Encoder counts of an angle of the joint, rad; signed like the encoder."""
        return round(angle * self.arm.drives[self.index].counts_per_radian)

    @property
    def torque_floor(self) -> int:
        """Codes of the joint's motor-current DAC that are no fault yet."""
        if not self.friction:
            return TORQUE_FLOOR_CODES
        friction = friction_set(self.arm, self.friction)[self.index]
        coulomb = max(friction.coulomb_positive, friction.coulomb_negative)
        return torque_floor(coulomb, self.arm.board_scale(self.index).torque_per_dac_code)

    @property
    def speed_limit(self) -> float:
        """The joint's, rad/s."""
        return self.arm.speed_limits[self.index]

    @property
    def period_s(self) -> float:
        """Of the control cycle, s."""
        return self.period_ns * 1e-9
