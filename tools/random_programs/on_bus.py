"""Random programs on the whole simulated bus, with plant and nodes: many in one run, in turn.

Each begins with a move in joint mode to where its seed has the arm stand at first. What a program
hears is what a user's program would: refusals, and how each move ended.
"""

from collections.abc import Sequence
from typing import Any, Final

from random_programs.draw import Move, Program, draw
from random_programs.judge import Judge
from random_programs.results import Brief
from rfms_can.arm import Arm, arm_by_name
from rfms_can.coordinator import Arm as Coordinator
from rfms_can.errors import FaultError, MoveError, RfmsError
from rfms_can.kinematics import configuration_of, direct
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.protection import Refusal
from rfms_can.wire.records import JointError

TOOL: Final = Transform.translation(0.0, 0.0, 0.1)
PAUSE_S: Final = 1.0
THERE: Final[dict[str, Any]] = {"acceleration_time": 0.4, "joint_speed": 0.5, "lengthen": True}
"""Mode in which the arm goes to where a program begins."""


class Commanded:
    """The commanded joint angles of each cycle, from ERROR and what the joints have measured.

    Args:
        arm: the arm.
        period_s: tau, s.
    """

    def __init__(self, arm: Arm, period_s: float) -> None:
        wire = Wire()
        self._arm = arm
        self._period = period_s
        self._decoders = {
            wire.id(JointError, joint): (wire.receiver(JointError, joint).decoder, joint)
            for joint in JOINTS
        }
        self._angles = [0.0] * len(JOINTS)
        self._heard = 0
        self.judge: Judge | None = None
        self.rig: SimulatedRig | None = None

    def watch(self, rig: Rig) -> None:
        """Listen to a run."""
        assert isinstance(rig, SimulatedRig)
        self.rig = rig
        rig.observe(self.take)

    def begin(self) -> None:
        """Judge from the next cycle on."""
        self.judge = None

    def take(self, _time_ns: int, frame: Frame) -> None:
        """One frame of the bus."""
        known = self._decoders.get(frame.id)
        if known is None or self.rig is None:
            return
        decoder, joint = known
        values = decoder.decode(frame)
        controller = self.rig.joints[joint - 1].controller
        if isinstance(values, Refusal) or controller is None:
            return
        self._angles[joint - 1] = controller.sensing.theta + values.error
        self._heard += 1
        if self._heard % len(JOINTS) == 0:
            if self.judge is None:
                self.judge = Judge(self._arm, self._angles, self._period)
            self.judge.take(self._angles)


class Batch:
    """Programs that run one after the other in one run.

    Args:
        arm: name of the arm.
        seeds: of the programs.
    """

    def __init__(self, arm: str, seeds: Sequence[int]) -> None:
        self._name = arm
        self._arm = arm_by_name(arm)
        self._seeds = seeds
        self._settings = RunSettings(arm=arm)
        self._commanded = Commanded(self._arm, 1.0 / self._settings.rate)
        self.results: list[Brief] = []
        self._last = 0  # number of the move that was accepted last

    def run(self) -> list[Brief]:
        """Run them; a fault ends the batch, and counts for the program it happened in."""
        try:
            outcome = execute(self.program, self._settings, watch=self._commanded.watch)
        except RfmsError as error:
            if len(self.results) == len(self._seeds):
                raise
            self._note(self._seeds[len(self.results)], 0, 0, "", str(error), 0)
            return self.results
        if outcome.fault is not None and len(self.results) < len(self._seeds):
            self._note(self._seeds[len(self.results)], 0, 0, "", str(outcome.fault), 0)
        return self.results

    def program(self, arm: Coordinator) -> None:
        """The programs as one."""
        tool = arm.transform("tool", TOOL)
        for seed in self._seeds:
            program = draw(self._arm, seed)
            self._go_to(arm, program)
            self._commanded.begin()
            began = arm.status.cycle
            accepted, why, bad = 0, "", ""
            try:
                for number, move in enumerate(program.moves):
                    self._last = self._ask(arm, tool, f"{seed}.{number}", move)
                    accepted += 1
                    self._go_on(arm, move)
                arm.wait(self._last)
            except MoveError:
                refused = program.moves[accepted]
                why = f"{refused.kind}, {refused.mode['interpolation']}"
                bad = self._end(arm)
            except FaultError:
                raise
            except RfmsError as error:
                bad = str(error) or type(error).__name__
            self._note(seed, len(program.moves), accepted, why, bad, arm.status.cycle - began)
        self._go_to(arm, program)  # to rest: its last goal may go on for ever

    def _end(self, arm: Coordinator) -> str:
        """What the moves before a refusal have come to."""
        try:
            arm.feed(1.0)
            arm.resume()
            arm.wait(self._last)
        except FaultError:
            raise
        except RfmsError as error:
            return str(error)
        return ""

    def _go_to(self, arm: Coordinator, program: Program) -> None:
        """To where the program begins."""
        arm.feed(1.0)
        arm.resume()
        pose = arm.transform("start", direct(self._arm, program.start))
        config = str(configuration_of(self._arm, program.start))
        position = arm.position("start", arm.t6 == pose, config=config)
        self._last = arm.move(position, arm.mode("there", **THERE))
        arm.wait(self._last)

    def _ask(self, arm: Coordinator, tool: Any, name: str, move: Move) -> int:
        """Ask for a move, and tell its number; see ``Trial``."""
        mode = arm.mode(name, **move.mode)
        if move.angles is not None:
            return arm.move(arm.joint_position(name, move.angles), mode)
        goal = arm.transform(f"at {name}", move.target @ TOOL)
        if move.function is not None:
            goal = goal @ arm.functional(f"by {name}", move.function)
        position = arm.position(name, arm.t6 @ tool == goal, tool=tool, config=move.configuration)
        return arm.move(position, mode)

    def _go_on(self, arm: Coordinator, move: Move) -> None:
        """Wait, or go on after some cycles; change the pace after the request."""
        period = 1.0 / self._settings.rate
        if move.pace is not None:
            after, rate = move.pace
            arm.sleep(after * period)
            if rate:
                arm.feed(rate)
            else:
                arm.pause()
                arm.sleep(PAUSE_S)
                arm.resume()
        if move.waits:
            arm.wait(self._last)  # at a goal that goes on the arm never rests
        else:
            arm.sleep(max(1, move.after) * period)

    def _note(self, seed: int, moves: int, accepted: int, why: str, bad: str, cycles: int) -> None:
        judge = self._commanded.judge
        speed, acceleration = (0.0, 0.0) if judge is None else (judge.speed, judge.acceleration)
        peaks = (round(speed, 4), round(acceleration, 4))
        self.results.append(
            Brief(self._name, seed, moves, accepted, why, "", bad, *peaks, cycles, 0)
        )
