"""What a trial has measured: plain numbers, which the judge reads."""

import msgspec

Cycles = float | None
"""Cycles from the first effect of the fault, 0 before it; None if it did not happen."""


class Facts(msgspec.Struct, frozen=True, kw_only=True):
    """What was measured of one trial.

    Attributes:
        node: number of the node at fault.
        injected: cycle after which the fault was put in.
        effect: cycles from there to its first effect; None if it had none.
        counted: cycles until some node had counted something.
        stopped: until some node left its motion: QUICKSTOP or FAULT.
        reached: until the reaction that the variant wants was reached where it wants it.
        halted: until the master had latched a fault.
        reactions: the hardest of each joint, 0 to 4.
        others: the least hard, at the end, of the joints that are not at fault.
        held: whether a node held its last set-point, or the master closed a cycle without all.
        named: whom the run's result blames: the culprit of the fault that the master has latched;
            where it has latched none, that of the first EMCY; empty if no one is blamed.
        told: the same in words.
        speed: largest speed of a joint over its limit, from the effect on.
        acceleration: the same of accelerations, from one cycle to the next.
        past_range: farthest way beyond a joint's range, rad.
        contact: whether a joint stood on its hard stop.
        brakes: joints, not at fault and not without torque, whose brake closed in motion.
        following: largest distance of a joint from the commanded angle while enabled, rad.
        reenabled: what was enabled again without RESET, in words.
        rest: until the arm was at rest; None if it was not at the end.
        refused: why a request was refused; None if none was made.
        enabled: whether the arm was enabled after the fault was put in.
        exit_code: of a run of this kind.
        unrecorded: what of its record is missing, as its result says.
        left: processes that it left behind.
    """

    node: int
    injected: int
    effect: float | None
    counted: Cycles = None
    stopped: Cycles = None
    reached: Cycles = None
    halted: Cycles = None
    reactions: list[int] = []
    others: int = 0
    held: bool = False
    named: str = ""
    told: str = ""
    speed: float = 0.0
    acceleration: float = 0.0
    past_range: float = 0.0
    contact: bool = False
    brakes: list[int] = []
    following: float = 0.0
    reenabled: list[str] = []
    rest: Cycles = None
    refused: str | None = None
    enabled: bool = False
    exit_code: int = 0
    unrecorded: list[str] = []
    left: list[str] = []
