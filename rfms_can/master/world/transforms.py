"""The symbol table of transforms: definitions, redefinitions, observations."""

import math
from collections import Counter
from collections.abc import Callable
from typing import Final, NamedTuple, get_args

from rfms_can.errors import TransformError
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world.functions import evaluator
from rfms_can.master.world.modes import Limits
from rfms_can.master.world.numbers import (
    MAX_SPEED,
    check_numbers,
    check_rigid,
    check_stamp,
)
from rfms_can.master.world.observed import Observation, rotation_vector
from rfms_can.master.world.reference import Reference
from rfms_can.master.world.tables import MAX_LIVE, MAX_TRANSFORMS, SymbolTable
from rfms_can.master.world.transform_kinds import Functional, Live
from rfms_can.messages import T6, TransformMessage
from rfms_can.messages.world import Kind
from rfms_can.tables import complete
from rfms_can.transform import Transform

EXACT: Final = 1e-12
"""``rigidity_error`` of a product of rotations in double precision, with room to spare."""


class Transforms:
    """Transforms by name; each keeps the kind it was defined with.

    Args:
        period_s: of the ticks, s.
    """

    def __init__(self, period_s: float) -> None:
        self._period: Final = period_s
        self.table: Final = SymbolTable[Transform | Live](
            "transform", MAX_TRANSFORMS, TransformError
        )
        self.kinds: Final[dict[str, Kind]] = {}
        self._counts: Final[Counter[Kind]] = Counter()
        self._moving: Final[dict[str, Reference]] = {}

    def define(self, message: TransformMessage, tick: int, limits: Limits | None) -> None:
        """Enter a transform, redefine it, or take an observation of it.

        Raises:
            TransformError: see :meth:`WorldModel.define_transform`. Nothing has changed.
        """
        rows = Transform(*message.rows)
        self._check(message, rows)
        _KINDS[message.kind].enter(self, message, rows, tick, limits)
        if message.name not in self.kinds:
            self.kinds[message.name] = message.kind
            self._counts[message.kind] += 1

    def remove(self, name: str) -> None:
        """Forget a transform; the caller has seen that nothing uses it."""
        del self.table[name]
        self._moving.pop(name, None)
        self._counts[self.kinds.pop(name)] -= 1

    def silent(self, tick: int) -> list[str]:
        """References that move on although an observation of them is overdue at a tick."""
        return [
            name
            for name, reference in self._moving.items()
            if reference.silent_from is not None and tick >= reference.silent_from
        ]

    def last_observed(self, name: str) -> str | None:
        """What was observed of a reference last, in words; None of one that was not."""
        reference = self.table.get(name)
        if not isinstance(reference, Reference):
            return None
        pose, time = reference.newest.pose, reference.newest.time
        return (
            f"reference {name!r} leads there, observed at ({pose.px:.4g}, {pose.py:.4g}, "
            f"{pose.pz:.4g}) m at t = {time:.3f} s"
        )

    def settle(self, name: str, tick: int, limits: Limits | None) -> None:
        """Bring a reference that moves to rest in its time, as no observation of it comes.

        Args:
            name: of the transform; one that does not move rests.
            tick: of the next set-point.
            limits: of the mode the arm moves with; None if nothing that moves uses it.
        """
        reference = self._moving.pop(name, None)
        if reference is not None and reference.silent_from is not None:
            reference.settle(tick, limits)

    def halt(self, name: str, tick: int, limits: Limits) -> None:
        """Bring a reference to rest within limits, as if it had been seen to stop ahead.

        Args:
            name: of the transform; one that is not a reference rests.
            tick: of the next set-point.
            limits: of the mode the arm moves with.
        """
        self._moving.pop(name, None)
        reference = self.table.get(name)
        if not isinstance(reference, Reference):
            return
        here, next_ = (reference.at(Moment(k, 1.0, 0.0)) for k in (tick, tick + 1))
        step = math.dist((here.px, here.py, here.pz), (next_.px, next_.py, next_.pz))
        turn = math.hypot(*rotation_vector(here.inverse() @ next_))
        needed = max(step / limits.acceleration, turn / limits.angular_acceleration)
        ahead = math.ceil(needed / self._period**2)  # v / a, in ticks
        reference.hold(reference.at(Moment(tick + ahead, 1.0, 0.0)), tick, limits)

    def _set(
        self, message: TransformMessage, rows: Transform, tick: int, limits: Limits | None
    ) -> None:
        if self.table.get(message.name) != rows:  # the same value stays the same object
            self.table[message.name] = rows

    def _set_function(
        self, message: TransformMessage, rows: Transform, tick: int, limits: Limits | None
    ) -> None:
        assert message.function is not None  # or the message would have been refused
        known = self.table.get(message.name)
        if isinstance(known, Functional) and known.is_of(rows, message.function):
            return
        function = evaluator(message.name, message.function)
        self.table[message.name] = Functional(rows, message.function, function)

    def _observe(
        self, message: TransformMessage, rows: Transform, tick: int, limits: Limits | None
    ) -> None:
        name, now = message.name, tick * self._period
        time = now
        if message.stamp is not None:
            check_stamp(name, message.stamp, now, self._period)
            time = min(message.stamp, now)
        twist = None
        if message.twist is not None:
            check_numbers(name, "its twist", message.twist, MAX_SPEED)
            vx, vy, vz, wx, wy, wz = message.twist
            twist = ((vx, vy, vz), (wx, wy, wz))
        reference = self.table.get(name)
        if not isinstance(reference, Reference):
            reference = self.table[name] = Reference(self._period)
        reference.predict = message.predict or reference.predict
        reference.rest_after = message.rest_after or reference.rest_after
        reference.observe(Observation(_orthonormal(rows), time, twist), tick, limits)
        if reference.silent_from is not None:
            self._moving[name] = reference

    def _check(self, message: TransformMessage, rows: Transform) -> None:
        """What all kinds have in common."""
        name, kind = message.name, message.kind
        definition = _KINDS[kind]
        if name == T6:
            raise TransformError(f"transform {T6!r} is the arm itself and cannot be defined")
        check_rigid(name, rows)
        known = self.kinds.get(name)
        if known is None:
            self._check_room(name, kind)
        elif known != kind:
            raise TransformError(
                f"transform {name!r} is of kind {known} and stays so, {kind} was requested; "
                f"use another name, or remove this one first"
            )
        if (message.function is not None) != definition.has_function:
            has = "no function" if message.function is None else "a function"
            raise TransformError(
                f"transform {name!r}: of kind {kind} with {has}; a functional transform has one, "
                f"and no other has"
            )
        observed = (message.twist, message.stamp, message.rest_after) != (None, None, None)
        if not definition.observed and (observed or message.predict == "velocity"):
            raise TransformError(
                f"transform {name!r}: of kind {kind} with a twist, a stamp, a prediction or a time "
                f"to come to rest; only a reference is observed"
            )

    def _check_room(self, name: str, kind: Kind) -> None:
        """Raise unless one more of a kind may be entered."""
        self.table.check_room(name)
        if kind != "value" and self._counts[kind] >= MAX_LIVE:
            raise TransformError(
                f"transform {name!r} is one too many: {MAX_LIVE} of kind {kind} are defined, and "
                f"no more may be; define one of them again, or remove what nothing uses"
            )


class _Kind(NamedTuple):
    """A kind of transform.

    Attributes:
        enter: takes a message that has been checked, its pose, the tick and the limits of the mode.
        has_function: whether a message of it has a function.
        observed: whether one may have a twist, a stamp and a prediction.
    """

    enter: Callable[[Transforms, TransformMessage, Transform, int, Limits | None], None]
    has_function: bool
    observed: bool


_KINDS: Final = complete(
    {
        "value": _Kind(Transforms._set, has_function=False, observed=False),
        "reference": _Kind(Transforms._observe, has_function=False, observed=True),
        "functional": _Kind(Transforms._set_function, has_function=True, observed=False),
    },
    get_args(Kind),
)


def _orthonormal(rows: Transform) -> Transform:
    """A pose given with few digits as a rotation; what is left out would be seen as a jump."""
    if rows.rigidity_error() <= EXACT:
        return rows
    _, ox, ax, px, _, oy, ay, py, _, oz, az, pz = rows
    return Transform.from_o_a_p((ox, oy, oz), (ax, ay, az), (px, py, pz))
