"""Systems that are warm: brought up and in motion, from which trials are forked.

Each stroke goes from one end of a span to the other, all joints at the same part of their speed
limits; a fault is put in where all of them are fast enough.
"""

from collections.abc import Sequence
from typing import Final

from rfms_can.arm import Arm, arm_by_name
from rfms_can.coordinator import Arm as Program
from rfms_can.coordinator.moves import Moves
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
STROKES: Final = 10
LAST_CYCLE: Final = 700
"""Of the strokes, from which on a fault is put in at the latest."""
NEAR: Final = "near"
FAR: Final = "far"
MODE: Final = "stroke"


def ends(arm: Arm, state: State) -> tuple[list[float], list[float]]:
    """Both ends of the strokes, rad (6 each)."""
    centre = list(arm.park)
    centre[4] = ELBOW_DOWN
    half = [HALF_SPAN_S * limit for limit in arm.speed_limits]
    if state is State.NEAR_END:
        centre[0] = arm.joint_limits[0][1] - CLEARANCE_RAD - half[0]
    return (
        [c - h for c, h in zip(centre, half, strict=True)],
        [c + h for c, h in zip(centre, half, strict=True)],
    )


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
        """Bring the arm up, take it to the near end, and let it go to and fro from there."""
        self.session.bring_up()
        near, far = ends(self.arm, self.state)
        program = self.program
        program.joint_position(NEAR, near)
        program.joint_position(FAR, far)
        program.mode(MODE, joint_speed=FASTEST, acceleration_time=0.25)
        program.move(NEAR, MODE)
        program.wait()
        self._begun = self.rig.master.statistics.cycles
        for _ in range(STROKES):
            program.move(FAR, MODE)
            program.move(NEAR, MODE)

    def run_to(self, cycle: int) -> None:
        """Run to the end of the first cycle of the strokes, from this on, where all are fast."""
        if self.state is State.START:
            return

        def there() -> bool:
            return self.cycle >= cycle and self.slowest >= SLOWEST

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
