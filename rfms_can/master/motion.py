"""Motion: what programs ask for, and the set-point of the next cycle, checked before it is sent."""

from collections.abc import Callable, Sequence
from typing import Any, Final

from rfms_can.arm import Arm
from rfms_can.errors import KinematicsError, MoveError, ProgramError
from rfms_can.kinematics import (
    Configuration,
    Joints,
    configuration_of,
    direct,
    singularity_margins,
)
from rfms_can.master.accepted_moves import AcceptedMove, AcceptedMoves
from rfms_can.master.force.requested import RequestedCompliance
from rfms_can.master.force.specification import ForceRequest
from rfms_can.master.trajectory.commanded import CommandedTrajectory
from rfms_can.master.trajectory.generator import TrajectoryGenerator
from rfms_can.master.trajectory.planning import MovePlanner
from rfms_can.master.world import Limits, WorldModel
from rfms_can.messages import (
    Answer,
    ComplyRequest,
    FeedRequest,
    LockRequest,
    Message,
    ModeMessage,
    MoveRequest,
    PauseRequest,
    PositionMessage,
    ResumeRequest,
    StopRequest,
    TransformMessage,
)
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.wire.vocabulary import Blend

NOTED: Final = Answer()
"""The answer to what has no more to say."""
WRIST_MARGIN = 1e-3
"""|sin theta5| under which an arm is not enabled: nodes could not tell theta4 from theta6."""


Vet = Callable[[ForceRequest, Joints, bool], str | None]
"""Why force control refuses the request of a move at joint angles, at rest or not; or None."""


class Motion:
    """Trajectory generator, its shadow of the six joints, and the world model.

    Args:
        arm: the arm.
        period_s: control period, s.
        blend: matching polynomial of transitions.
        vet: says why force control refuses the request of a move, or None.

    Attributes:
        force_request: of the move in progress; None before the first.
        generator: the master's half of the trajectory generator.
        commanded: the commanded trajectory, in double precision.
        world: symbol tables.
    """

    def __init__(self, arm: Arm, period_s: float, blend: Blend, vet: Vet) -> None:
        self._arm = arm
        self._period = period_s
        self._vet = vet
        self.commanded = CommandedTrajectory(arm, period_s)
        self.generator = TrajectoryGenerator(period_s, blend)
        self._planner = MovePlanner(arm, period_s)
        self._sequence = 0
        self.world = WorldModel(Configuration(True, True, True), period_s)
        self._moves = AcceptedMoves()
        self._requested = RequestedCompliance()
        self.force_request: ForceRequest | None = None
        self._acts: Final[dict[type[Message], Callable[[Any], Answer | None]]] = {
            TransformMessage: self._define_transform,
            PositionMessage: self._define_position,
            ModeMessage: self._define_mode,
            MoveRequest: self._move,
            StopRequest: self._stop,
            PauseRequest: self._pause,
            ResumeRequest: self._resume,
            FeedRequest: self._feed,
            ComplyRequest: self._requested.comply,
            LockRequest: self._requested.lock,
        }

    def enable(self, q: Sequence[float]) -> None:
        """Hold where the encoders say the arm is (rad), without a move and without a force request.

        Raises:
            KinematicsError: the wrist is singular there.
        """
        self._hold(q)
        self.force_request = None

    def _hold(self, q: Sequence[float]) -> None:
        """Hold at joint angles (rad); moves start from there, those accepted before are over."""
        arm = self._arm
        margin = singularity_margins(arm, q).wrist
        if abs(margin) < WRIST_MARGIN:
            raise KinematicsError(
                f"{arm.name}: wrist singularity: sin(theta5) = {margin:.3g}, enabling needs "
                f"{WRIST_MARGIN:g} or more; move joint 5 away from zero first"
            )
        configuration = configuration_of(arm, q)
        self.world.configuration = configuration
        self.generator.enable(direct(arm, q), configuration)
        self.commanded.reset(q)
        self._planner.reset(self.commanded.theta)
        self._moves.clear()

    def forget(self) -> None:
        """Begin with empty symbol tables and rigid, for another program; the motion goes on."""
        self._requested.forget()
        self.world = WorldModel(self.world.configuration, self._period)
        self._moves.forget()

    def handle(self, message: Message) -> Answer:
        """Do what a program asks.

        Raises:
            ProgramError: the request is refused; nothing has changed.
        """
        act = self._acts.get(type(message))
        if act is None:
            raise ProgramError(f"{type(message).__name__} is not a request for motion")
        return act(message) or NOTED

    def _define_transform(self, message: TransformMessage) -> None:
        limits = self._limits(message.name)
        self.world.define_transform(message, self.generator.tick_count, limits)

    def _define_position(self, message: PositionMessage) -> None:
        self.world.define_position(message, self.generator.tick_count)

    def _define_mode(self, message: ModeMessage) -> None:
        self.world.define_mode(message)

    def _stop(self, _: StopRequest) -> None:
        """Come to rest on the path; goals that move by themselves come to rest as well."""
        self.generator.stop()
        for name in self.world.names().transforms:
            limits = self._limits(name)
            if limits is not None:
                self.world.halt_transform(name, self.generator.tick_count, limits)

    def _pause(self, _: PauseRequest) -> None:
        self.generator.pause()

    def _resume(self, _: ResumeRequest) -> None:
        self.generator.resume()

    def _feed(self, request: FeedRequest) -> None:
        self.generator.set_feed(request.rate)

    def _move(self, request: MoveRequest) -> Answer:
        position = self.world.position(request.position)
        mode = self.world.mode(request.mode)
        sequence, generator = self._sequence + 1, self.generator
        before, tick = generator.last_accepted, generator.tick_count
        accepted = AcceptedMove.of(position, mode, self._requested, tick)
        self._admit(sequence, accepted)
        try:
            plan = self._planner.plan(
                before, position, mode, sequence, tick, generator.periods_left
            )
            generator.request(*plan.moves)
        except (MoveError, KinematicsError) as error:
            raise MoveError(f"to {request.position!r} with {request.mode!r}: {error}") from error
        self._sequence = sequence
        self._moves.add(sequence, accepted, generator.sequence)
        return Answer(sequence, plan.segment_time, plan.via_deviation, plan.via_rotation)

    def _admit(self, sequence: int, move: AcceptedMove) -> None:
        """Refuse a move behind a guarded one, or a force beyond the arm's torque."""
        name = f"to {move.position.name!r} with {move.mode.name!r}: "
        guarded, generator = self._moves.last_guarded, self.generator
        if guarded and not self.is_over(guarded):
            raise MoveError(
                f"{name}move {guarded} is guarded, so its end is not known in advance: "
                f"wait for it before asking for another"
            )
        request = move.force_request(sequence, self._tick)
        reason = self._vet(request, self.commanded.theta, generator.at_rest)
        if reason:
            raise MoveError(name + reason)

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

    def end_guarded(self) -> None:
        """The guard of the move under way has tripped: come to rest on the path."""
        self.generator.stop()

    def _limits(self, transform: str) -> Limits | None:
        """What a jump of a transform may add to the motion under way, or to the one settled next.

        None if neither goes where it matters.
        """
        settled = len(self.generator.active_goals) - 1
        active = self._moves.going_to(transform, self.generator.sequence, settled)
        limits = [move.mode.limits for move in active]
        return Limits(*map(min, zip(*limits, strict=True))) if limits else None

    def next_setpoint(self) -> tuple[CartesianSetpoint, str | None]:
        """The set-point of the next cycle, and why it must not be sent, or None."""
        generator, world = self.generator, self.world
        if generator.stopped:
            self._hold(self.commanded.theta)  # force control goes on complying where it stopped
        for name in world.unseen(generator.tick_count):
            world.halt_transform(name, generator.tick_count, self._limits(name))
        setpoint = generator.tick()
        self._take_over(generator.sequence)
        return setpoint, self.commanded.check(setpoint)

    @property
    def comply(self) -> str:
        """Directions the program has requested to comply in, e.g. ``"fx fy rx ry"``."""
        return self._requested.selection.word

    @property
    def moves(self) -> bool:
        """Whether the arm is commanded to move in the set-point made last."""
        return any(self.commanded.rate)

    def is_over(self, sequence: int) -> bool:
        """Whether a move is complete: at rest at its goal, or handed over to the next.

        One that a stop has dropped is over when the arm rests.
        """
        return self.generator.completed >= sequence or self.generator.at_rest

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves and nothing waits."""
        return self.generator.at_rest
