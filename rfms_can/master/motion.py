"""Motion: what programs ask for, and the set-point of the next cycle, checked before it is sent."""

import math
from collections.abc import Callable, Sequence
from typing import Any, Final

from rfms_can.arm import Arm
from rfms_can.errors import KinematicsError, MoveError, ProgramError, TrackingError
from rfms_can.kinematics import (
    Configuration,
    Joints,
    configuration_of,
    direct,
)
from rfms_can.master.accepted_moves import AcceptedMove, AcceptedMoves, Request
from rfms_can.master.force.requested import RequestedCompliance
from rfms_can.master.force.specification import ForceRequest
from rfms_can.master.trajectory.following import Following
from rfms_can.master.trajectory.generator import TrajectoryGenerator
from rfms_can.master.trajectory.planning import MovePlanner, with_straight_wrist
from rfms_can.master.trajectory.queue import MAX_QUEUE
from rfms_can.master.waiting_moves import WaitingMoves
from rfms_can.master.world import JointPosition, Limits, WorldModel
from rfms_can.messages import (
    Answer,
    ComplyRequest,
    FeedRequest,
    JointPositionMessage,
    LockRequest,
    Message,
    ModeMessage,
    MoveRequest,
    Outcome,
    PauseRequest,
    PositionMessage,
    RemoveRequest,
    ResumeRequest,
    StopRequest,
    TransformMessage,
)
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.wire.vocabulary import Blend

Definition = TransformMessage | PositionMessage | JointPositionMessage | ModeMessage
NOTED: Final = Answer()
"""The answer to what has no more to say."""
Vet = Callable[[ForceRequest, Joints, bool], str | None]
"""Why force control refuses the request of a move at joint angles, at rest or not; or None."""


class Motion:
    """Trajectory generator, the six joints that follow it, and the world model.

    Args:
        arm: the arm.
        period_s: control period, s.
        blend: matching polynomial of transitions.
        vet: says why force control refuses the request of a move, or None.
        replans: moves that a redefinition may plan again in one cycle, at most.
        effort: poses that may be solved for one request.

    Attributes:
        force_request: of the move in progress; None before the first.
        stopped_short: why the arm last came to rest beside its path, or None.
        planner: of moves, in the order of their requests.
        generator: the master's half of the trajectory generator.
        following: what the joints make of its path.
        commanded: the commanded trajectory.
        world: symbol tables.
    """

    def __init__(
        self,
        arm: Arm,
        period_s: float,
        blend: Blend,
        vet: Vet,
        replans: int = MAX_QUEUE,
        effort: float = math.inf,
    ) -> None:
        self._arm = arm
        self._period = period_s
        self._vet = vet
        self.following = Following(arm, period_s, blend)
        self.commanded = self.following.commanded
        self.generator = TrajectoryGenerator(period_s, blend)
        self.planner = MovePlanner(arm, period_s, effort)
        self._sequence = 0
        self.world = WorldModel(Configuration(True, True, True), period_s)
        self._moves = AcceptedMoves()
        self._waiting = WaitingMoves(
            self.generator, self.planner, self._moves, self._refusal, replans
        )
        self._requested = RequestedCompliance()
        self.force_request: ForceRequest | None = None
        self.stopped_short: str | None = None
        self._untold: str | None = None  # the arm stopped short at rest: no move tells
        self._acts: Final[dict[type[Message], Callable[[Any], Answer | None]]] = {
            TransformMessage: self._define,
            PositionMessage: self._define,
            JointPositionMessage: self._define,
            ModeMessage: self._define,
            RemoveRequest: self._remove,
            MoveRequest: self._move,
            StopRequest: self._stop,
            PauseRequest: self._pause,
            ResumeRequest: self._resume,
            FeedRequest: self._feed,
            ComplyRequest: self._requested.comply,
            LockRequest: self._requested.lock,
        }

    def enable(self, q: Sequence[float]) -> None:
        """Hold where the encoders say the arm is (rad), without a move or a force request."""
        self._hold(q)
        self.following.enable(self.commanded.theta)
        self._requested.forget()
        self.force_request = None

    def _hold(self, q: Sequence[float]) -> None:
        """Hold at joint angles (rad); moves start from there, those accepted before are over."""
        arm = self._arm
        q1, q2, q3, q4, q5, q6 = q
        q = with_straight_wrist((q1, q2, q3, q4, q5, q6))
        configuration = configuration_of(arm, q)
        self.world.configuration = configuration
        self.generator.enable(direct(arm, q), configuration, q)
        self.following.hold(q)
        self.planner.reset(self.commanded.theta)
        self._moves.clear()

    def forget(self) -> None:
        """Begin with empty symbol tables and rigid, for another program; the motion goes on."""
        self._requested.forget()
        self.world = WorldModel(self.world.configuration, self._period)
        self._moves.forget()
        self._untold = None

    def handle(self, message: Message) -> Answer:
        """Do what a program asks.

        Raises:
            ProgramError: the request is refused; nothing has changed. A ``TrackingError`` tells
                once that the arm no longer follows the goal it had come to.
        """
        if self._untold is not None:
            untold, self._untold = self._untold, None
            raise TrackingError(f"stopped short: {untold}")
        self.planner.effort.begin()
        act = self._acts.get(type(message))
        if act is None:
            raise ProgramError(f"{type(message).__name__} is not a request for motion")
        return act(message) or NOTED

    def _define(self, message: Definition) -> Answer:
        """Define a name, and bind the moves that have not begun to what it stands for now."""
        world = self.world
        former = world.former(message)
        _ENTER[type(message)](self, message)
        try:
            replanned = self._waiting.bind(world) if world.differs(former) else []
        except (MoveError, KinematicsError) as error:
            world.restore(former)
            raise MoveError(
                f"{former.what} {former.name!r} stays as it was, because an accepted move could "
                f"not be made ({error}); define it otherwise, wait for that move, or stop"
            ) from error
        if former.what == "position":
            world.note_levers(world.position(message.name), self.generator.tick_count)
        return Answer(replanned=replanned)

    def _define_transform(self, message: TransformMessage) -> None:
        limits = self._limits(message.name)
        self.world.define_transform(message, self.generator.tick_count, limits)

    def _define_joint_position(self, message: JointPositionMessage) -> None:
        self.world.define_joint_position(JointPosition(message, self._arm))

    def _remove(self, request: RemoveRequest) -> None:
        """Remove a name that no position uses, and no move that is not over."""
        former = self.world.entry_of(request)
        what, name = former.what, former.name
        user = self._moves.user(what, name, self.generator.sequence)
        follows = what == "transform"  # a reference acts also where the arm rests
        if user and (follows or not self.is_over(user)):
            doing, until = (
                ("follows it", "move elsewhere, or stop,")
                if follows
                else ("is to be made with it", "wait for it")
            )
            raise ProgramError(f"{what} {name!r}: move {user} {doing}: {until} before removing it")
        self.world.remove(former)

    def _stop(self, _: StopRequest) -> None:
        self.stop(Outcome.STOPPED, "stopped by stop()")

    def stop(self, how: Outcome, reason: str) -> None:
        """Come to rest on the path; goals that move by themselves come to rest as well.

        Args:
            how: the outcome of the moves that are stopped or dropped.
            reason: who or what stops them.
        """
        generator = self.generator
        generator.stop(how, reason)
        active = self._moves.active(generator.sequence, len(generator.active_goals) - 1)
        names = (name for move in active for name in move.position.references)
        for name in dict.fromkeys(names):
            limits = self._limits(name)
            if limits is not None:
                self.world.halt_transform(name, generator.tick_count, limits)

    def settle(self, name: str) -> None:
        """A reference is not observed any more: it comes to rest in the time it states."""
        self.world.settle_transform(name, self.generator.tick_count, self._limits(name))

    def _pause(self, _: PauseRequest) -> None:
        self.generator.pause()

    def _resume(self, _: ResumeRequest) -> None:
        self.generator.resume()

    def _feed(self, request: FeedRequest) -> None:
        self.generator.set_feed(request.rate)

    def _move(self, request: MoveRequest) -> Answer:
        requested = self._requested
        names = Request(request.position, request.mode, requested.selection, requested.bias)
        sequence, generator = self._sequence + 1, self.generator
        tick = generator.tick_count
        accepted = AcceptedMove.bound(names, self.world, tick)
        self._admit(sequence, accepted)
        try:
            plan = self.planner.plan(generator.entry, accepted.position, accepted.mode, sequence)
            generator.request(*plan.moves)
        except (MoveError, KinematicsError) as error:
            refusal = MoveError(f"{accepted.words}: {error}")
            refusal.remedy = error.remedy
            raise refusal from error
        self._sequence = sequence
        self.world.note_levers(accepted.position, tick)
        self._moves.add(sequence, accepted, generator.sequence)
        return Answer(sequence, plan.segment_time, plan.via_deviation, plan.via_rotation)

    def _admit(self, sequence: int, move: AcceptedMove) -> None:
        """Refuse a move behind a guarded one, or a force beyond the arm's torque."""
        guarded = self._moves.last_guarded
        if guarded and not self.is_over(guarded):
            raise MoveError(
                f"{move.words}: move {guarded} is guarded, so its end is not known in advance: "
                f"wait for it before asking for another"
            )
        reason = self._refusal(sequence, move)
        if reason:
            raise MoveError(f"{move.words}: {reason}")

    def _refusal(self, sequence: int, move: AcceptedMove) -> str | None:
        """Why force control refuses a move that has not begun, or None."""
        request = move.force_request(sequence, self._tick)
        rests = self.generator.departs_from_rest(sequence)
        return self._vet(request, self.commanded.theta, rests)

    def _tick(self) -> int:
        return self.generator.tick_count

    def _take_over(self, sequence: int) -> None:
        """A move that takes over brings its force request."""
        if self.force_request is not None and self.force_request.sequence == sequence:
            return
        move = self._moves.get(sequence)
        if move is not None:
            self.force_request = move.force_request(sequence, self._tick)

    @property
    def guarded(self) -> bool:
        """Whether the move under way stops on force or distance: until it is over."""
        request = self.force_request
        return request is not None and (
            request.specification.guard.active and not self.is_over(request.sequence)
        )

    def end_guarded(self, reason: str) -> None:
        """The guard of the move under way has tripped: come to rest on the path."""
        generator = self.generator
        generator.outcomes.ends((generator.sequence,), Outcome.GUARDED, reason)
        generator.stop(Outcome.GUARDED, reason)

    def _limits(self, transform: str) -> Limits | None:
        """What a jump of a transform may add to the motion under way, or to the one settled next.

        None if neither goes where it matters.
        """
        settled = len(self.generator.active_goals) - 1
        active = self._moves.going_to(transform, self.generator.sequence, settled)
        limits = [move.mode.limits for move in active]
        return Limits(*map(min, zip(*limits, strict=True))) if limits else None

    def next_setpoint(self) -> CartesianSetpoint:
        """The set-point of the next cycle: of the path, or of a stop where none can follow it."""
        generator, world, following = self.generator, self.world, self.following
        if following.brakes and not following.has_braked:
            generator.pass_tick()
            return following.slow_down(generator.sequence)
        if following.brakes or generator.stopped:
            self._hold(self.commanded.theta)  # force control goes on complying where it stopped
        for name in world.silent(generator.tick_count):
            self.settle(name)
        setpoint = generator.tick()
        refusal = following.refusal(setpoint)
        if refusal is None:
            self._take_over(generator.sequence)
            return setpoint
        return self._stop_short(refusal)

    def _stop_short(self, refusal: str) -> CartesianSetpoint:
        """The joints cannot follow the path any further: come to rest beside it."""
        generator = self.generator
        self.stopped_short = f"{refusal}{self._blame()}"
        if not generator.brake(self.stopped_short):
            self._untold = self.stopped_short
        return self.following.brake(generator.sequence)

    def _blame(self) -> str:
        """The references that lead the move under way, and what was observed of them last."""
        move = self._moves.get(self.generator.sequence)
        if move is None:
            return ""
        led = [self.world.last_observed(name) for name in move.position.references]
        return "".join(f"; {text}" for text in led if text)

    @property
    def comply(self) -> str:
        """Directions the program has requested to comply in, e.g. ``"fx fy rx ry"``."""
        return self._requested.selection.word

    def is_over(self, sequence: int) -> bool:
        """Whether a move is over: made, handed over to the next, or ended by something else.

        One that was stopped or dropped is over when the arm rests.
        """
        return self.generator.completed >= sequence

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves and nothing waits."""
        return self.generator.at_rest


_ENTER: Final[dict[type[Definition], Callable[[Motion, Any], object]]] = {
    TransformMessage: Motion._define_transform,
    PositionMessage: lambda motion, message: motion.world.define_position(message),
    JointPositionMessage: Motion._define_joint_position,
    ModeMessage: lambda motion, message: motion.world.define_mode(message),
}
"""What enters a definition into the world model."""
