"""Motions said by what they relate: approach, depart, guarded approach, insert, follow.

Each is a function that returns a :class:`Task`. ``tool`` is the frame, in T6, that gets somewhere,
``frame`` where it gets; both are a :class:`Frame`, or what ``arm.transform`` and ``arm.reference``
returned. What a motion defines is named after it: ``approach part: near`` is a mode of
``approach(tool, part)``, and ``task.change("near", speed=0.05)`` changes it.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from rfms_can.coordinator import ModeSettings, ProgramError
from rfms_can.task.actions import Grip, Move, Tare
from rfms_can.task.checks import forces, number, offset, positive
from rfms_can.task.contact import Follow, Insertion, Look, Touch
from rfms_can.task.motion import NAME, Motion, Place
from rfms_can.task.steps import Step
from rfms_can.task.task import Task

BACK: Final = (0.0, 0.0, -0.05)
"""Off a frame, back along its z: where an approach begins and a departure ends, m."""
FAR: Final[ModeSettings] = {"joint_speed": 0.5, "acceleration_time": 0.25, "lengthen": True}
"""A free motion: fast, in joint mode."""
BLEND_S: Final = 0.2
"""Acceleration time of straight motions that blend with free ones, s."""
DEEPEST_M: Final = 0.5
"""Deepest insertion, m."""
MOUTH: Final = {"fx": 0.0, "fy": 0.0}
"""A peg in the chamfer: the hole leads it aside."""
GUIDED: Final = {"fx": 0.0, "fy": 0.0, "rx": 0.0, "ry": 0.0}
"""A peg in the hole (5.2): the hole turns it, too."""

JOIN: Final[ModeSettings] = {
    "segment_time": 0.7,
    "acceleration_time": 0.3,
    "interpolation": "cartesian",
}
"""A motion to a frame that moves."""
HALT: Final[ModeSettings] = {"segment_time": 0.4, "acceleration_time": 0.1}
"""A motion to where the arm has been stopped."""


def approach(
    tool: Place,
    frame: Place,
    *,
    by: Sequence[float] = BACK,
    speed: float = 0.1,
    far: Mapping[str, Any] | None = None,
    config: str | None = None,
    wait: bool = True,
    name: str | None = None,
) -> Task:
    """A fast motion to a point off a frame, then a slow straight one to it.

    The first blends into the second: the point off the frame is passed at a distance, which
    ``change("near", deviation=...)`` bounds.

    Args:
        tool: the frame that gets there.
        frame: where it gets.
        by: the point, in the axes of ``frame``, m; up to 1 m off.
        speed: of the straight motion, m/s; its mode is ``near``.
        far: settings of the fast one, instead of those of ``FAR``; its mode is ``far``.
        config: branch of the inverse kinematics; None: the arm's own when enabled.
        wait: whether the task waits there; otherwise it blends into what follows.
        name: what its definitions are named after; None: ``approach`` and the frame.

    Raises:
        ProgramError: or the class of it that the program API would raise: a frame, a number or a
            setting is invalid.
    """
    motion = Motion("approach", tool, frame, config, name)
    over = motion.at("over", motion.off("back", by))
    there = motion.at("at", motion.frame)
    fast, slow = (
        motion.mode("far", FAR, far),
        motion.straight("near", speed, acceleration_time=BLEND_S),
    )
    return motion.task(Move(over, fast, wait=False), Move(there, slow, wait))


def depart(
    tool: Place,
    frame: Place,
    *,
    by: Sequence[float] = BACK,
    speed: float = 0.1,
    comply: Mapping[str, float] | None = None,
    config: str | None = None,
    wait: bool = True,
    name: str | None = None,
) -> Task:
    """A slow straight motion from a frame, where the tool is, to a point off it.

    Args:
        tool, frame, by, config, wait, name: see :func:`approach`.
        speed: m/s; its mode is ``leave``.
        comply: directions in which the arm yields on the way, each with a bias, N or N m: of a
            peg that leaves its hole those of ``GUIDED``.

    Raises:
        ProgramError: or the class of it that the program API would raise.
    """
    motion = Motion("depart", tool, frame, config, name)
    away = motion.at("away", motion.off("back", by))
    yields = None if comply is None else forces(motion.label, "comply", comply, signed=True)
    return motion.task(
        Move(away, motion.straight("leave", speed, comply=yields, acceleration_time=BLEND_S), wait)
    )


def guarded_approach(
    tool: Place,
    frame: Place,
    *,
    force: Mapping[str, float],
    by: Sequence[float] = BACK,
    at_most: float | None = None,
    speed: float = 0.01,
    far: Mapping[str, Any] | None = None,
    tare: bool = False,
    config: str | None = None,
    name: str | None = None,
) -> Task:
    """A fast motion to a point off a frame, then a slow straight one that ends on contact.

    Its report has the distance travelled to contact. On a stiff part more force is met than asked
    for: what the arm runs on in the time it takes to stop.

    Args:
        tool, frame, by, config, name: see :func:`approach`; the straight motion goes on beyond the
            frame, in the direction it came in.
        force: directions of the tool's frame, and the force or moment along each, N or N m, in
            either sense, that is contact.
        at_most: travel of the straight motion without contact, m, up to 1; None: twice ``by``, as
            far beyond the frame as before it.
        speed: of the straight motion, m/s; its mode is ``feel``.
        far: see :func:`approach`; the mass of the tool belongs here.
        tare: whether to measure the wrist sensor's bias before the straight motion.

    Raises:
        ProgramError: or the class of it that the program API would raise. When it runs: no contact
            came, with the distance travelled.
    """
    motion = Motion("guarded approach", tool, frame, config, name)
    x, y, z = offset(motion.label, by)
    reach = (x * x + y * y + z * z) ** 0.5
    travel = (
        2.0 * reach if at_most is None else positive(motion.label, "at_most", at_most, 1.0, "m")
    )
    beyond = travel / reach - 1.0
    over = motion.at("over", motion.off("back", by))
    end = motion.at("beyond", motion.shifted("through", -beyond * x, -beyond * y, -beyond * z))
    contact = forces(motion.label, "force", force, signed=False)
    fast = motion.mode("far", FAR, far)
    feel = motion.straight("feel", speed, stop_on_force=contact)
    first: list[Step] = [Move(over, fast), *([Tare()] if tare else [])]
    return motion.task(*first, Touch(motion.label, end, feel))


def insert(
    peg: Place,
    hole: Place,
    depth: float,
    *,
    chamfer: float,
    guided: float,
    force: Mapping[str, float] | None = None,
    at_mouth: Mapping[str, float] = MOUTH,
    in_hole: Mapping[str, float] = GUIDED,
    entry_speed: float = 0.003,
    speed: float = 0.02,
    last_speed: float = 0.01,
    tolerance: float = 0.001,
    config: str | None = None,
    name: str | None = None,
) -> Task:
    """A peg down a hole of uncertain place (Fig. 1.1), complying as the hole asks for (5.2).

    It begins where an approach has left the peg: close to the mouth, on its axis. Slowly through
    the chamfer, where the arm yields aside; down to where the hole leads the peg; and to the
    bottom, where the arm yields to what turns it, too. Its report has the depth, by the encoders.
    The arm goes on yielding until the next move: let go of the peg, or depart complying.

    Args:
        peg: its end in T6, z out of it; a frame of the task, as its depth is told by it.
        hole: the middle of its mouth, z into it; a frame of the task.
        depth: m, up to 0.5.
        chamfer: depth at which the peg has passed the chamfer, m; mode ``enter`` up to there.
        guided: depth from which the hole turns the peg, m; mode ``slide`` up to there, then
            ``finish``.
        force: forces and moments, N or N m, at which it gives up; None: no such bound.
        at_mouth, in_hole: directions of the peg's frame that yield, each with a bias, N or N m, up
            to ``guided`` and from there on; not fz, along which the peg is led.
        entry_speed, speed, last_speed: of the three modes, m/s.
        tolerance: how much short of ``depth`` the peg may end, m.
        config, name: see :func:`approach`.

    Raises:
        ProgramError: or the class of it that the program API would raise. When it runs: it got
            stuck, with the depth and the force.
    """
    motion = Motion("insert", peg, hole, config, name, roles=("peg", "hole"))
    bottom = positive(motion.label, "depth", depth, DEEPEST_M, "m")
    slack = number(motion.label, "tolerance", tolerance, 0.0, bottom, "m")
    ways: list[tuple[str, str]] = []
    bounds = None if force is None else forces(motion.label, "force", force, signed=False)
    before = 0.0
    for place, mode, to, v, asked in (
        ("entered", "enter", chamfer, entry_speed, ("at_mouth", at_mouth)),
        ("guided", "slide", guided, speed, ("at_mouth", at_mouth)),
        ("bottom", "finish", bottom, last_speed, ("in_hole", in_hole)),
    ):
        number(motion.label, f"depth {place!r}", to, 0.0, bottom, "m")
        if not to > before:
            raise ProgramError(
                f"{motion.label}: depth {place!r} {to!r} m is not beyond {before:g} m: give "
                f"0 < chamfer < guided < depth"
            )
        yields = forces(motion.label, *asked, signed=True)
        if "fz" in yields:
            raise ProgramError(
                f"{motion.label}: {asked[0]} {yields}: along fz the peg is led down the hole, and "
                f"cannot yield; bound the force: force={{'fz': ...}}"
            )
        position = motion.at(place, motion.shifted(f"deep to {place}", 0.0, 0.0, to))
        ways.append((position, motion.straight(mode, v, comply=yields, stop_on_force=bounds)))
        before = to
    return motion.task(
        Insertion(motion.label, motion.tool.parts, motion.frame.parts, tuple(ways), bottom, slack)
    )


def follow(
    tool: Place,
    frame: Place,
    *,
    duration: float | None = None,
    until: Look | None = None,
    look: Look | None = None,
    every: float = 0.02,
    by: Sequence[float] | None = None,
    keep: bool = False,
    join: Mapping[str, Any] | None = None,
    config: str | None = None,
    name: str | None = None,
) -> Task:
    """A straight motion, in its own frame, to a frame that moves, and staying with it.

    Args:
        tool, config, name: see :func:`approach`.
        frame: has a reference in it, which the program or a sensor observes.
        duration: how long to stay, from the arrival on, s, up to an hour; None: until ``until``.
        until: called with the arm every so often, from the arrival on; true ends it.
        look: called with the arm every so often, from the beginning on: sends an observation.
        every: time between two such looks, s, 0.001 to 10.
        by: a point off the frame to stay at, m; None: at the frame.
        keep: whether the arm goes on following afterwards; otherwise it is stopped, and lets go of
            the frame with a short move to where it has come to rest.
        join: settings of the motion to the frame, instead of 0.7 s and a transition of 0.3 s; its
            mode is ``join``.

    Raises:
        ProgramError: or the class of it that the program API would raise: neither ``duration`` nor
            ``until`` is given, say.
    """
    motion = Motion("follow", tool, frame, config, name)
    if duration is None and until is None:
        raise ProgramError(f"{motion.label}: when it ends is not said: give duration= or until=")
    for what, given in (("until", until), ("look", look)):
        if given is not None and not callable(given):
            raise ProgramError(
                f"{motion.label}: {what} {given!r}: give a function of the arm, or None"
            )
    stays = (
        None if duration is None else number(motion.label, "duration", duration, 0.0, 3600.0, "s")
    )
    there = motion.at("at", motion.frame if by is None else motion.off("off", by))
    mode = motion.mode("join", JOIN, join)
    step = number(motion.label, "every", every, 0.001, 10.0, "s")
    rest = None if keep else motion.rest(HALT)
    return motion.task(Follow(there, mode, stays, until, look, step, rest))


def grip(force: float = 1.0) -> Task:
    """Close the gripper with a fraction of the full force, more than 0, up to 1.

    Raises:
        ProgramError: the force is out of bounds.
    """
    return Task(NAME, (Grip(opens=False, force=force),))


def release(force: float = 1.0) -> Task:
    """Open the gripper; see :func:`grip`."""
    return Task(NAME, (Grip(opens=True, force=force),))
