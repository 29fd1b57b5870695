"""The moves that were accepted: goal, mode, and what they request of force control."""

from collections.abc import Callable
from typing import NamedTuple

from rfms_can.arm import Load
from rfms_can.master.force.requested import RequestedCompliance
from rfms_can.master.force.specification import ForceRequest, Specification
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world import MotionMode, Position
from rfms_can.transform import Transform


class AcceptedMove(NamedTuple):
    """An accepted move: goal, mode, and its force-control request.

    Attributes:
        position, mode: where to and how.
        specification: what it requests of force control.
    """

    position: Position
    mode: MotionMode
    specification: Specification

    @classmethod
    def of(
        cls, position: Position, mode: MotionMode, program: RequestedCompliance, tick: int
    ) -> "AcceptedMove":
        """A move requested now: its mode says what complies, or else the program has said it."""
        selection, bias = mode.comply or (program.selection, program.bias)
        load = None
        if mode.mass is not None:
            tool = position.tool(Moment(tick))
            load = Load(mode.mass, mode.mass_centre or (tool.px, tool.py, tool.pz))
        return cls(position, mode, Specification(selection, bias, mode.guard, load))

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

    def going_to(self, transform: str, under_way: int, settled: int) -> list[AcceptedMove]:
        """The move in progress and those settled after it, if their position uses a transform."""
        later = [sequence for sequence in self._moves if sequence > under_way][:settled]
        active = [self._moves[k] for k in (under_way, *later) if k in self._moves]
        return [move for move in active if move.position.uses(transform)]
