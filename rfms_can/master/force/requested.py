"""Directions that the program lets comply: they hold for the moves it requests from then on."""

from rfms_can.compliance.selection import Selection, parse_bias
from rfms_can.master.force.specification import NO_FORCE
from rfms_can.master.rows.compliance import RIGID
from rfms_can.messages import ComplyRequest, LockRequest, Vector6


class RequestedCompliance:
    """``comply`` adds directions, ``lock`` takes them back (RCCL).

    Attributes:
        selection: directions of the compliance frame.
        bias: force along them, N and N m.
    """

    __slots__ = ("bias", "selection")

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Comply in nothing: rigid."""
        self.selection: Selection = RIGID
        self.bias: Vector6 = NO_FORCE

    def comply(self, request: ComplyRequest) -> None:
        """Comply in more directions, or with another force.

        Raises:
            SelectionError: a word does not name a direction, or values do not fit the words.
        """
        added, bias = parse_bias(request.word, request.values)
        self.selection = self.selection.with_(added)
        self.bias = _pick(added, bias, self.bias)

    def lock(self, request: LockRequest) -> None:
        """Be rigid in these again.

        Raises:
            SelectionError: a word does not name a direction.
        """
        self.selection = self.selection.without(Selection.parse(request.word))
        self.bias = _pick(self.selection, self.bias, NO_FORCE)


def _pick(selection: Selection, these: Vector6, others: Vector6) -> Vector6:
    """These where the selection has a direction, the others where not."""
    a, b, c, d, e, f = (x if s else y for s, x, y in zip(selection, these, others, strict=True))
    return (a, b, c, d, e, f)
