"""Requests of a program that must be refused before anything of them reaches the bus."""

from collections.abc import Callable
from typing import Final

import msgspec

from rfms_can.errors import LinkError, RfmsError
from rfms_can.faults.site import Site
from rfms_can.master.server.core import Server
from rfms_can.messages import MAX_BYTES, Reply
from rfms_can.transform import Transform

FAR_M: Final = 10.0
"""Out of any arm's reach, m; out of any joint's range, rad."""
TOO_SHORT_S: Final = 0.05
"""No segment can be made in this time, s."""
GARBAGE_BYTES: Final = 200
_PEER: Final = b"trial"
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


def malformed(site: Site) -> None:
    """Messages to the arm's server that no client of ours sends."""
    server, draw = Server(site.rig.master), site.context.draw
    whole = msgspec.msgpack.encode({"type": "move", "session": "x", "serial": 1})
    refusals = [
        _answer_to(server, data)
        for data in (
            *(b"", draw.randbytes(GARBAGE_BYTES), bytes(MAX_BYTES + 1), b"\x91" * GARBAGE_BYTES),
            *(whole, whole[: len(whole) // 2], msgspec.msgpack.encode(["move"] * 9)),
        )
    ]
    if all(refusals):
        raise LinkError("; ".join(refusals))


def _answer_to(server: Server, data: bytes) -> str:
    """Why a message was refused; empty if it was not."""
    replies = [
        msgspec.msgpack.decode(out.data, type=Reply) for out in server.receive(_PEER, data, 0)
    ]
    refusals = [reply.refusal for reply in replies if reply.refusal is not None]
    return refusals[0].reason if refusals and len(refusals) == len(replies) else ""


def refusal_of(ask: Callable[[Site], None], site: Site) -> str:
    """Why a request was refused; empty if it was not."""
    try:
        ask(site)
    except RfmsError as error:
        return str(error)
    return ""
