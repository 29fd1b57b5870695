"""The moves that were accepted: goal, mode, and what they request of force control."""

from collections.abc import Callable
from typing import Final, NamedTuple, get_args

from rfms_can.arm import Load
from rfms_can.compliance.selection import Selection
from rfms_can.master.force.specification import ForceRequest, Specification
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world import AnyPosition, MotionMode, WorldModel
from rfms_can.messages import Vector6
from rfms_can.messages.world import What
from rfms_can.tables import complete
from rfms_can.transform import Transform


class Request(NamedTuple):
    """A request to move: names, and what the program has let comply when it made it.

    Attributes:
        position, mode: names.
        selection: directions that comply, unless the mode says it.
        bias: force along them, N and N m.
    """

    position: str
    mode: str
    selection: Selection
    bias: Vector6


class AcceptedMove(NamedTuple):
    """An accepted move: goal, mode, and its force-control request.

    Attributes:
        request: as the program made it.
        position, mode: where to and how: what their names stood for when it was bound.
        specification: what it requests of force control.
    """

    request: Request
    position: AnyPosition
    mode: MotionMode
    specification: Specification

    @classmethod
    def bound(cls, request: Request, world: WorldModel, tick: int) -> "AcceptedMove":
        """A request bound to what its names stand for now.

        Raises:
            ProgramError: one of them is not defined.
        """
        return cls._of(request, world.position(request.position), world.mode(request.mode), tick)

    def bound_again(self, world: WorldModel, tick: int) -> "AcceptedMove":
        """The same request bound to what its names stand for now; itself if that is the same."""
        position, mode = world.position(self.request.position), world.mode(self.request.mode)
        if position is self.position or position.is_same(self.position):
            position = self.position  # with the goal it has
            if mode == self.mode:
                return self
        return self._of(self.request, position, mode, tick)

    @classmethod
    def _of(
        cls, request: Request, position: AnyPosition, mode: MotionMode, tick: int
    ) -> "AcceptedMove":
        """Its mode says what complies, or else the program has said it."""
        selection, bias = mode.comply or (request.selection, request.bias)
        load = None
        if mode.mass is not None:
            tool = position.tool(Moment(tick))
            load = Load(mode.mass, mode.mass_centre or (tool.px, tool.py, tool.pz))
        return cls(request, position, mode, Specification(selection, bias, mode.guard, load))

    @property
    def words(self) -> str:
        """For errors."""
        return f"to {self.position.name!r} with {self.mode.name!r}"

    def force_request(self, sequence: int, clock: Callable[[], int]) -> ForceRequest:
        """As force control sees it; its compliance frame is evaluated at each tick of the clock."""
        position = self.position

        def frame(T6: Transform) -> Transform:
            return position.compliance_frame(Moment(clock()), T6)

        return ForceRequest(sequence, self.specification, frame, self.mode.acceleration_time)


class AcceptedMoves:
    """The accepted moves that are not over, by their sequence numbers.

    Attributes:
        last_guarded: number of the last one that stops on force or distance; 0 before the first.
    """

    __slots__ = ("_moves", "last_guarded")

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all moves."""
        self._moves: dict[int, AcceptedMove] = {}
        self.last_guarded = 0

    def forget(self) -> None:
        """Another program: its moves are not those of the last, which may still be guarded."""
        self._moves.clear()

    def get(self, sequence: int) -> AcceptedMove | None:
        """The move of a number, if it is not over."""
        return self._moves.get(sequence)

    def add(self, sequence: int, move: AcceptedMove, under_way: int) -> None:
        """Add a move; those before the one in progress are over."""
        self._moves = {k: each for k, each in self._moves.items() if k >= under_way}
        self._moves[sequence] = move
        if move.specification.guard.active:
            self.last_guarded = sequence

    def replace(self, moves: dict[int, AcceptedMove]) -> None:
        """Take moves that wait as they are bound now; of these only the last may be guarded."""
        self._moves.update(moves)
        for sequence, move in moves.items():
            if move.specification.guard.active:
                self.last_guarded = sequence
            elif self.last_guarded == sequence:
                self.last_guarded = 0  # those before are over, or this one would not have waited

    def user(self, what: What, name: str, under_way: int) -> int:
        """Number of the last move, of the one in progress and those after it, that uses a name.

        Args:
            what: it names: a position, a mode, or a reference that the arm follows.
            name: of that.
            under_way: number of the move in progress.

        Returns:
            The number; 0 if none does.
        """
        uses = _USES[what]
        users = (k for k, move in self._moves.items() if k >= under_way and uses(move, name))
        return max(users, default=0)

    def going_to(self, transform: str, under_way: int, settled: int) -> list[AcceptedMove]:
        """The move in progress and those settled after it, if their position uses a transform."""
        return [move for move in self.active(under_way, settled) if move.position.uses(transform)]

    def active(self, under_way: int, settled: int) -> list[AcceptedMove]:
        """The move in progress and those settled after it."""
        later = [sequence for sequence in self._moves if sequence > under_way][:settled]
        return [self._moves[k] for k in (under_way, *later) if k in self._moves]


_USES: Final[dict[What, Callable[[AcceptedMove, str], bool]]] = complete(
    {
        "transform": lambda move, name: name in move.position.references,
        "position": lambda move, name: move.request.position == name,
        "mode": lambda move, name: move.request.mode == name,
    },
    get_args(What),
)
"""Whether a move needs what a name stands for: values and functions it has bound."""
