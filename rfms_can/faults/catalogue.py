"""Every injector by its name: at which seam it works, at which node, what it does.

``rfms run --fault NAME:NODE@CYCLE`` takes these names; the table of faults (``table.py``) says what
each has to lead to.
"""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, Final, NamedTuple

from rfms_can.faults import boards, frames, nodes, requests, singular, stations
from rfms_can.faults.context import Seam
from rfms_can.faults.frames import FOR_EVER, OFTEN
from rfms_can.faults.site import Site
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.plant.board import HIGHEST_CODE, LOWEST_CODE, JointBoard
from rfms_can.plant.faulty_board import FaultyBoard
from rfms_can.tables import complete
from rfms_can.wire.nodes import MASTER, PLANT
from rfms_can.wire.records import Dac, Heartbeat, JointError, Measure, Rows, Setpoint, Sync

JOINT: Final = 0
"""Of an injector: the node at fault is a joint, drawn or named."""
FULL_SCALE_CODES: Final = HIGHEST_CODE - LOWEST_CODE
WAKES_AFTER: Final = 20
"""Periods after which a hung node wakes."""
REJOINS_AFTER: Final = 10


class Injector(NamedTuple):
    """A fault that can be put in.

    Attributes:
        seam: where.
        node: number of the node at fault; ``JOINT`` where it is any joint.
        does: what is wrong then, for documentation.
        make: of the fault; its kind is the seam's.
    """

    seam: Seam
    node: int
    does: str
    make: Callable[..., Any]


def _bus(node: int, does: str, make: frames.Make) -> Injector:
    return Injector(Seam.BUS, node, does, make)


def _tap(node: int, does: str, make: nodes.Install) -> Injector:
    return Injector(Seam.TAP, node, does, make)


def _board(make: boards.MakeDamage, does: str) -> Injector:
    return Injector(Seam.BOARD, JOINT, does, make)


def _rig(node: int, does: str, make: Callable[[Site], None]) -> Injector:
    return Injector(Seam.RIG, node, does, make)


def _asks(does: str, make: Callable[[Site], None]) -> Injector:
    return Injector(Seam.PROGRAM, MASTER, does, make)


_SENDERS: Final = {
    "sync": (Sync, MASTER),
    "setpoint": (Setpoint, MASTER),
    "measure": (Measure, JOINT),
    "error": (JointError, JOINT),
    "dac": (Dac, JOINT),
    "rows": (Rows, JOINT),
}
"""Messages of a cycle; of those that six joints have the one of the joint drawn."""


def _of_messages(
    template: str, words: Iterable[str], does: str, make: Callable[[type[Any]], frames.Make]
) -> dict[str, Injector]:
    """One injector a message."""
    made = {}
    for word in words:
        record, node = _SENDERS[word]
        made[template.format(word)] = _bus(node, does.format(word.upper()), make(record))
    return made


def _frames(
    verdict: frames.Verdict, count: int = 1, every: int = 1
) -> Callable[[type[Any]], frames.Make]:
    return partial(frames.of_message, verdict=verdict, count=count, every=every)


_ONE: Final = ("setpoint", "measure", "error", "dac")
_ALL: Final = ("sync", *_ONE)


def _wakes(site: Site, node: int) -> None:
    """The node hangs, and wakes later."""
    tap = site.tap(node)
    (nodes.stops_at_its_deadline if node == MASTER else nodes.hangs)(site.context, tap)

    def wake() -> None:
        tap.hung = False
        site.rig.bus.exchange(site.controller(node), tap)

    site.later(WAKES_AFTER * site.context.period_ns, wake)


def _rejoins(site: Site) -> None:
    """The joint falls silent, and starts again later."""
    context = site.context
    tap = site.tap(context.node)
    nodes.hangs(context, tap)

    def start() -> None:
        tap.node = site.rig.joints[context.index] = JointNode(
            context.node, context.wire, stations.OTHER_BOOT
        )
        tap.hung = False
        site.rig.bus.exchange(site.controller(context.node), tap)

    site.later(REJOINS_AFTER * context.period_ns, start)


def _restarts(site: Site) -> None:
    """The joint starts again at once."""
    context = site.context
    tap = site.tap(context.node)
    fresh = JointNode(context.node, context.wire, stations.OTHER_BOOT)
    tap.node = site.rig.joints[context.index] = fresh
    site.rig.bus.exchange(site.controller(context.node), tap)
    site.touch()


INJECTORS: Final[dict[str, Injector]] = {
    **_of_messages("lose_{}", (*_ALL, "rows"), "one {} is lost", _frames(frames.lost)),
    **_of_messages(
        *("burst_{}", _ALL, "five {} in a row are lost"), _frames(frames.lost, frames.BURST)
    ),
    "deaf_plant": _bus(PLANT, "the plant gets no frame for five cycles", frames.deaf(PLANT)),
    "deaf_joint": _bus(JOINT, "a joint gets no frame for five cycles", frames.deaf()),
    **_of_messages("copy_{}", _ONE, "one {} comes twice", _frames(frames.copied)),
    **_of_messages(
        *("delay_{}", _ONE, "one {} comes 0.9 periods late"), partial(frames.late, frames.LATE)
    ),
    **_of_messages(
        *("swap_{}", _ONE, "one {} comes behind its follower"), partial(frames.late, frames.BEHIND)
    ),
    **_of_messages("corrupt_{}", _ALL, "one {} has a wrong bit", _frames(frames.corrupt)),
    **_of_messages(
        *("corrupt_{}_often", _ONE, "every third {} has a wrong bit"),
        _frames(frames.corrupt, FOR_EVER, OFTEN),
    ),
    **_of_messages("shorten_{}", ("setpoint",), "one {} has 7 bytes", _frames(frames.short)),
    **_of_messages(
        *("lengthen_{}", ("measure", "error", "dac"), "one {} is four bytes longer"),
        _frames(frames.long),
    ),
    **_of_messages(
        *("classic_{}", ("dac",), "one {} comes as classic CAN"), _frames(frames.classic)
    ),
    "stick_sync": _tap(MASTER, "SYNC is sent again and again", nodes.same_frame(Sync)),
    "stick_setpoint": _tap(MASTER, "SETPOINT is sent again and again", nodes.same_frame(Setpoint)),
    "stick_measure": _tap(
        *(PLANT, "MEASURE of a joint is sent again and again"), nodes.same_frame(Measure)
    ),
    "stick_error": _tap(JOINT, "ERROR is sent again and again", nodes.same_frame(JointError)),
    "stick_dac": _tap(JOINT, "DAC is sent again and again", nodes.same_frame(Dac)),
    "freeze_encoder": _board(boards.frozen_encoder, "the encoder shows one angle for ever"),
    "freeze_tachometer": _board(boards.frozen_tachometer, "the velocity ADC shows one speed"),
    "freeze_error": _tap(
        *(JOINT, "ERROR tells one error for ever"),
        nodes.same_values(JointError, ("cycle",), nodes.other_error),
    ),
    "freeze_dac": _tap(
        *(JOINT, "DAC tells one torque for ever"),
        nodes.same_values(Dac, ("cycle",), nodes.other_torque),
    ),
    "freeze_setpoint": _tap(
        *(MASTER, "SETPOINT tells one pose for ever"),
        nodes.same_values(Setpoint, ("cycle", "sequence")),
    ),
    "stop_master": _tap(MASTER, "the master ends", nodes.stops_at_its_deadline),
    "stop_joint": _tap(JOINT, "the node of a joint ends", nodes.hangs),
    "restart_joint": _rig(JOINT, "the node of a joint starts again at once", _restarts),
    "rejoin_joint": _rig(JOINT, "the node of a joint ends, and starts again later", _rejoins),
    "mute_plant": _tap(PLANT, "nothing comes from the plant", nodes.falls_silent),
    "hang_joint": _rig(
        JOINT, "the node of a joint hangs for 20 periods", lambda s: _wakes(s, s.context.node)
    ),
    "hang_master": _rig(MASTER, "the master hangs for 20 periods", lambda s: _wakes(s, MASTER)),
    "bus_off_joint": _rig(JOINT, "the controller of a joint is bus-off", stations.bus_off),
    "flood": _rig(MASTER, "a stranger takes most of the bus", stations.flood),
    "babble_error": _tap(
        *(JOINT, "a joint sends ERROR ten times as often"), nodes.babbles(JointError, JointError)
    ),
    "babble_heartbeat": _tap(
        *(JOINT, "a joint sends HEARTBEAT twenty times in each cycle"),
        nodes.babbles(Heartbeat, JointError),
    ),
    "full_queue_once": _rig(JOINT, "a joint can send nothing for one cycle", stations.full_once),
    "full_queue": _rig(JOINT, "a joint can send nothing any more", stations.full_for_ever),
    "late_master_once": _rig(MASTER, "the master is late in one cycle", stations.late_once),
    "late_master": _rig(MASTER, "the master is late in every cycle", stations.late_for_ever),
    "nan_setpoint_once": _tap(
        *(MASTER, "one SETPOINT has a NaN"),
        nodes.sends(Setpoint, nodes.number("p_x", nodes.NAN), 1),
    ),
    "nan_setpoint": _tap(
        *(MASTER, "every SETPOINT has a NaN"), nodes.sends(Setpoint, nodes.number("p_x", nodes.NAN))
    ),
    "nan_error_once": _tap(
        *(JOINT, "one ERROR has a NaN"),
        nodes.sends(JointError, nodes.number("error_rate", nodes.NAN), 1),
    ),
    "nan_rows_once": _tap(
        *(JOINT, "one ROWS of a joint has a NaN"),
        nodes.hears(Rows, nodes.number("gravity", nodes.NAN), 1),
    ),
    "far_error_once": _tap(
        *(JOINT, "one ERROR tells 50 rad"),
        nodes.sends(JointError, nodes.number("error", nodes.FAR_RAD), 1),
    ),
    "far_error": _tap(
        *(JOINT, "every ERROR tells 50 rad"),
        nodes.sends(JointError, nodes.number("error", nodes.FAR_RAD)),
    ),
    "glitch_encoder": _board(boards.glitch, "one sample of the encoder is far away"),
    "jump_encoder": _board(boards.jump, "the encoder jumps by 0.1 rad, and stays there"),
    "drift_encoder": _board(boards.drift, "the encoder slips at 0.3 of the speed limit"),
    "turn_potentiometer": _board(
        boards.turned_potentiometer,
        "the coarse position is up to a quarter of the range off, between two indexes",
    ),
    "reverse_motor": _board(boards.reversed_motor, "the motor's leads are exchanged"),
    "reverse_encoder": _board(boards.reversed_encoder, "the encoder counts backwards"),
    "reverse_tachometer": _board(
        boards.reversed_tachometer, "the tachometer's leads are exchanged"
    ),
    "stick_amplifier": _board(boards.stuck_amplifier, "the amplifier drives 0.6 of its current"),
    "drive_to_the_end": _rig(
        *(JOINT, "the same, towards the upper end of the range"), stations.drive_to_the_end
    ),
    "push_to_the_end": _rig(
        *(JOINT, "joint 1 is pushed up a little harder than its friction"),
        stations.push_to_the_end,
    ),
    "push_through": _rig(
        JOINT, "joint 1 is pushed up harder than its motor can", stations.push_through
    ),
    "kill_amplifier": _board(boards.dead_amplifier, "the amplifier drives no current"),
    "boost_amplifier": _board(boards.strong_amplifier, "the amplifier drives four times as much"),
    "rail_current": _board(boards.current_rail, "the current ADC is saturated"),
    "rail_velocity": _board(boards.velocity_rail, "the velocity ADC is saturated"),
    "seize_brake": _rig(JOINT, "the brake of a joint holds for ever", stations.seized_brake),
    "run_on": _rig(
        MASTER, "SETPOINT turns joint 1 to the end of its range", stations.run_to_the_end
    ),
    "step_setpoint_once": _tap(
        *(MASTER, "one SETPOINT is 50 mm elsewhere"),
        nodes.sends(Setpoint, nodes.values(nodes.step_away), 1),
    ),
    "step_setpoint": _tap(
        *(MASTER, "every SETPOINT is 50 mm elsewhere"),
        nodes.sends(Setpoint, nodes.values(nodes.step_away)),
    ),
    "ask_unreachable": _asks("a move to a pose out of reach", requests.unreachable),
    "ask_no_rotation": _asks("a transform that is no rotation", requests.no_rotation),
    "redefine_position": _asks("a goal is redefined out of range", requests.redefined_position),
    "redefine_mode": _asks("a mode is redefined too fast", requests.redefined_mode),
    "ask_malformed": _asks("messages that are none", requests.malformed),
    "ask_too_many": _asks("more moves than the queue takes", requests.too_many),
    "ask_singular_line": _asks("a fast line close by a straight wrist", singular.line),
    "slow_singular_line": _asks(
        "a line not far from a straight wrist, which may take longer", singular.slow_line
    ),
    "lead_singular": _asks(
        "a goal that moves by itself leads the arm by a straight wrist", singular.led
    ),
    "second_master": _rig(MASTER, "a second master is switched on", stations.second_master),
    "foreign_sync": _rig(MASTER, "a stranger sends SYNC", stations.foreign_sync),
    "second_joint": _rig(JOINT, "a second node of a joint is on the bus", stations.second_joint),
    "foreign_dac": _rig(JOINT, "a stranger sends DAC of a joint", stations.foreign_dac),
    "other_hash_sync": _tap(
        *(MASTER, "SYNC names another DBC"), nodes.sends(Sync, nodes.values(nodes.other_hash))
    ),
    "other_hash_joint": _tap(
        *(JOINT, "HEARTBEAT of a joint names another DBC"),
        nodes.sends(Heartbeat, nodes.values(nodes.other_hash)),
    ),
    "scale_rows_once": _tap(
        *(JOINT, "one set of rows of a joint is four times too large"),
        nodes.hears(Rows, nodes.values(nodes.scaled_rows), 1),
    ),
    "scale_rows": _tap(
        *(JOINT, "the rows of a joint are four times too large"),
        nodes.hears(Rows, nodes.values(nodes.scaled_rows)),
    ),
    "wrong_gravity_once": _tap(
        *(JOINT, "gravity of a joint is once wrong by half its torque limit"),
        nodes.hears(Rows, nodes.values(nodes.heavy), 1),
    ),
    "wrong_gravity": _tap(
        *(JOINT, "gravity of a joint is wrong by half its torque limit"),
        nodes.hears(Rows, nodes.values(nodes.heavy)),
    ),
}
"""By name."""


def _disturb(injector: Injector, site: Site) -> None:
    site.rig.bus.disturber = injector.make(site.context)


def _tamper(injector: Injector, site: Site) -> None:
    at = injector.node or site.context.node
    tap = site.tap(at)
    injector.make(site.context, tap)
    site.rig.bus.exchange(site.controller(at), tap)  # its deadline may be another one now


def _damage(injector: Injector, site: Site) -> None:
    damage = injector.make(site.context)
    floor = site.context.torque_floor
    if damage.polarity < 0:  # leads turned round behind the current's sensor: motion alone shows it
        floor = 2 * FULL_SCALE_CODES
        site.touch_when(site.strays)

    def exchange(board: JointBoard) -> JointBoard:
        return FaultyBoard(board, damage, site.touch, floor)

    site.rig.plant.physics.exchange_board(site.context.index, exchange)


def _ask(injector: Injector, site: Site) -> None:
    site.refused = requests.refusal_of(injector.make, site)
    if site.refused:
        site.touch()


_INJECT: Final[dict[Seam, Callable[[Injector, Site], None]]] = complete(
    {
        Seam.BUS: _disturb,
        Seam.TAP: _tamper,
        Seam.BOARD: _damage,
        Seam.RIG: lambda injector, site: injector.make(site),
        Seam.PROGRAM: _ask,
    },
    Seam,
)


def inject(name: str, site: Site) -> None:
    """Put a fault into a simulated system, now."""
    injector = INJECTORS[name]
    _INJECT[injector.seam](injector, site)
