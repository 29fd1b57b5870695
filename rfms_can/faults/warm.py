"""Systems that are warm: brought up and in motion, from which trials are forked.

Each stroke goes from one end of a span to the other, all joints at the same part of their speed
limits; a fault is put in where all of them are fast enough.
"""

from collections.abc import Sequence
from typing import Final

from rfms_can.arm import Arm, arm_by_name
from rfms_can.coordinator import Arm as Program
from rfms_can.coordinator.moves import Moves
from rfms_can.faults.singular import stand_before
from rfms_can.faults.table import State
from rfms_can.rig.session import Session
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig

FASTEST: Final = 0.55
"""Of the motion, over each joint's speed limit."""
SLOWEST: Final = 0.3
"""At which a fault may be put in."""
HALF_SPAN_S: Final = 0.16
"""Half the span of a joint, over its speed limit, s."""
ELBOW_DOWN: Final = -1.0
"""Centre of joint 5, rad: clear of the wrist's singularity and of the end of its range."""
CLEARANCE_RAD: Final = 0.15
"""Of joint 1 from the upper end of its range, where it moves close to it."""
CLOSE_RAD: Final = 0.06
"""The same where the arm complies: it may not be displaced far."""
STROKES: Final = 10
LAST_CYCLE: Final = 700
"""Of the strokes, from which on a fault is put in at the latest."""
ALL_DIRECTIONS: Final = "fx fy fz rx ry rz"
LAST_MOVE_RAD: Final = 0.02
"""Of joint 6, with which an arm begins to comply."""
NEAR: Final = "near"
FAR: Final = "far"
MODE: Final = "stroke"
_STILL: Final = (State.START, State.AT_WRIST)
"""In which nothing moves when a fault is put in."""


def ends(arm: Arm, state: State) -> tuple[list[float], list[float]]:
    """Both ends of the strokes, rad (6 each)."""
    centre = list(arm.park)
    centre[4] = ELBOW_DOWN
    half = [HALF_SPAN_S * limit for limit in arm.speed_limits]
    if state is State.NEAR_END:
        centre[0] = arm.joint_limits[0][1] - CLEARANCE_RAD - half[0]
    if state is State.COMPLYING:  # there at the near end, from which it does not go far
        centre[0] = arm.joint_limits[0][1] - CLOSE_RAD + half[0]
    return (
        [c - h for c, h in zip(centre, half, strict=True)],
        [c + h for c, h in zip(centre, half, strict=True)],
    )


def approach(program: Program, arm: Arm, state: State) -> None:
    """Take an arm that is enabled to the near end; both ends and the mode are defined then."""
    near, far = ends(arm, state)
    program.joint_position(NEAR, near)
    program.joint_position(FAR, far)
    program.mode(MODE, joint_speed=FASTEST, acceleration_time=0.25)
    program.move(NEAR, MODE)
    program.wait()


def go_to_and_fro(program: Program, strokes: int = STROKES) -> None:
    """Ask for so many strokes to the far end and back; does not wait for them."""
    for _ in range(strokes):
        program.move(FAR, MODE)
        program.move(NEAR, MODE)


class WarmSystem:
    """A simulated system at power-up; ``move`` brings it up and lets it move.

    Args:
        arm: name of the arm.
        state: of the system when a fault is put in.

    Attributes:
        settings: of the run.
        rig: the nodes and their bus.
        session: brings it up.
        program: the program API.
    """

    def __init__(self, arm: str, state: State) -> None:
        self.state = state
        self.settings = RunSettings(arm=arm)
        self.arm = arm_by_name(arm)
        self.rig = SimulatedRig(self.settings)
        self.session = Session(self.rig, keep=True)
        self.program = Program(self.session.link, Moves())
        self._begun = 0

    def begin(self) -> None:
        """Let it do what its state says."""
        if self.state is not State.START:
            self.move()

    def move(self) -> None:
        """Bring the arm up, and let it go to and fro, or stand before a straight wrist."""
        self.session.bring_up()
        if self.state is State.AT_WRIST:
            stand_before(self.program, self.arm)
            return
        if self.state is State.COMPLYING:
            self._comply()
            return
        approach(self.program, self.arm, self.state)
        self._begun = self.rig.master.statistics.cycles
        go_to_and_fro(self.program)

    def _comply(self) -> None:
        """Let go of the arm where it is to be: it floats, its weight borne."""
        program, (near, _) = self.program, ends(self.arm, self.state)
        program.joint_position(NEAR, near)
        program.joint_position(FAR, [*near[:5], near[5] + LAST_MOVE_RAD])
        program.mode(MODE, joint_speed=FASTEST, acceleration_time=0.25)
        program.move(NEAR, MODE)
        program.wait()
        program.comply(ALL_DIRECTIONS, *(0.0,) * 6)
        program.move(FAR, MODE)
        program.wait()
        self._begun = self.rig.master.statistics.cycles

    def run_to(self, cycle: int) -> None:
        """Run to the end of the first cycle of the strokes, from this on, where all are fast."""
        if self.state in _STILL:
            return

        def there() -> bool:
            fast = self.state is State.COMPLYING or self.slowest >= SLOWEST
            return self.cycle >= cycle and fast

        self.session.link.run_until(there)

    @property
    def cycle(self) -> int:
        """Of the strokes."""
        return self.rig.master.statistics.cycles - self._begun

    @property
    def slowest(self) -> float:
        """Speed of the slowest joint, over its limit."""
        speeds: Sequence[float] = self.rig.plant.physics.true_qd
        return min(abs(v) / limit for v, limit in zip(speeds, self.arm.speed_limits, strict=True))
