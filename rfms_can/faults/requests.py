"""Requests of a program that must be refused before anything of them reaches the bus."""

from collections.abc import Callable
from typing import Final

from rfms_can.errors import RfmsError
from rfms_can.faults.site import Site
from rfms_can.transform import Transform

FAR_M: Final = 10.0
"""Out of any arm's reach, m; out of any joint's range, rad."""
TOO_SHORT_S: Final = 0.05
MOVES: Final = 300
"""More moves than any queue takes."""


def unreachable(site: Site) -> None:
    """A move to a pose out of the arm's reach."""
    arm = site.program
    goal = arm.transform("far away", Transform.translation(FAR_M, 0.0, 0.0))
    arm.move(arm.position("out of reach", arm.t6 == goal), site.mode)


def no_rotation(site: Site) -> None:
    """A transform whose matrix is no rotation."""
    rows = [[2.0, 0.0, 0.0, 0.3], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.3]]
    site.program.transform("no rotation", Transform.from_rows(rows))


def redefined_position(site: Site) -> None:
    """A position that accepted moves go to is redefined to where no arm can go."""
    site.program.joint_position(site.goal, [FAR_M] * 6)


def redefined_mode(site: Site) -> None:
    """The mode of accepted moves is redefined so fast that no joint can make them."""
    site.program.mode(site.mode, segment_time=TOO_SHORT_S, acceleration_time=TOO_SHORT_S / 2.0)


def too_many(site: Site) -> None:
    """More moves than the queue takes."""
    arm = site.program
    for _ in range(MOVES):
        arm.move(site.goal, site.mode)


def refusal_of(ask: Callable[[Site], None], site: Site) -> str:
    """Why a request was refused; empty if it was not."""
    try:
        ask(site)
    except RfmsError as error:
        return str(error)
    return ""
