"""Programs over a link to a server's own core: the same arm, the same errors, a lease."""

from collections.abc import Callable

import msgspec
import pytest
from support.link import CoreSocket, status
from support.programs.short_program import program
from support.server import SECOND, Coordinator, ServerBench

from rfms_can.coordinator import Arm, connect, emergency_stop
from rfms_can.coordinator.conversation import ANSWER_S, UNREAD, Conversation, Lease
from rfms_can.coordinator.mode_settings import ModeSettings
from rfms_can.coordinator.refusals import ERRORS, error_of
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.errors import (
    EquationError,
    FaultError,
    JointPositionError,
    LeaseError,
    LinkError,
    ModeError,
    MoveError,
    ProgramError,
    TransformError,
)
from rfms_can.messages import AtRest, LeaseRequest, MoveRequest, Query, Refusal, Reply, Status
from rfms_can.rig.session import Session
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame

LONG_LEASE_S = 10.0
"""Longer than a test: the thread that renews it has nothing to do."""


@pytest.fixture
def bench(wire: Wire) -> ServerBench:
    return ServerBench(wire)


@pytest.fixture
def socket(bench: ServerBench, monkeypatch: pytest.MonkeyPatch) -> CoreSocket:
    """The socket ``connect`` gets."""
    one = CoreSocket(bench, b"program")
    monkeypatch.setattr("rfms_can.coordinator.connection.ClientSocket", lambda *_: one)
    return one


@pytest.fixture
def link(socket: CoreSocket) -> RemoteLink:
    made = RemoteLink(socket, "cell", LONG_LEASE_S, now=socket.now)
    made.acquire()
    return made


@pytest.fixture
def arm(link: RemoteLink) -> Arm:
    return Arm(link)


def unnumbered(told: Status) -> Status:
    """A status without its number: to ask for one is to make another one."""
    return msgspec.structs.replace(told, issued=0)


PUSHES = ModeSettings(segment_time=0.6, acceleration_time=0.1, comply={"fx": 900.0})


def lift(arm: Arm, seconds: float = 0.6, height: float = 0.03) -> int:
    """A move straight up; its number."""
    there = arm.transform("there", Transform.translation(0.0, 0.0, height) @ arm.pose)
    arm.position("up", arm.t6 == there)
    arm.mode("slow", segment_time=seconds, acceleration_time=0.1)
    return arm.move("up", "slow")


# --- the same arm ------------------------------------------------------------------------------


@pytest.mark.system
def test_a_program_moves_the_arm_as_in_the_masters_process(
    bench: ServerBench, arm: Arm, wire: Wire
) -> None:
    """Every frame of every cycle has the same payload."""
    rig = SimulatedRig(RunSettings(friction="none"), wire)
    here: list[Frame] = []
    rig.observe(lambda _, frame: here.append(frame))
    session = Session(rig)
    session.bring_up()
    here.clear()
    program(Arm(session.link))
    program(arm)
    assert len(here) > 5000
    assert arm.status.cycle == session.link.status().cycle
    assert bench.frames == here


@pytest.mark.system
def test_what_is_seen_of_the_arm_is_what_the_server_tells(bench: ServerBench, arm: Arm) -> None:
    before = arm.pose
    arm.wait(lift(arm))
    told = bench.server.status()
    assert unnumbered(arm.status) == unnumbered(told)
    assert arm.joints == told.joints
    assert arm.time == told.time == (told.cycle - 1) * 0.004
    assert arm.pose.pz - before.pz == pytest.approx(0.03, abs=1e-3)
    plan = arm.plan(1)
    assert plan.segment_time == pytest.approx(0.6)


def test_time_stands_between_two_waits(arm: Arm) -> None:
    arm.sleep(0.1)
    cycle = arm.status.cycle
    for _ in range(5):
        arm.transform("there", Transform.identity())
    assert arm.status.cycle == cycle
    arm.sleep(0.1)
    assert arm.status.cycle == cycle + 25


def test_compliance_is_kept_by_the_server(arm: Arm) -> None:
    arm.comply("fx ry", 0.0, 1.0)
    arm.comply("fy", 2.0)
    assert arm.status.comply == "fx fy ry"
    arm.lock("ry fx")
    arm.sleep(0.004)
    assert arm.status.comply == "fy"
    with pytest.raises(ProgramError, match="lock 'fx': fx does not comply; what does: fy"):
        arm.lock("fx")


@pytest.mark.system
def test_over_the_link_too_a_program_sees_what_complies_and_what_stopped_a_move(arm: Arm) -> None:
    assert (arm.complied, arm.force, arm.guard) == ((0.0,) * 6, (0.0,) * 6, None)
    assert arm.status.force_loop == "none"
    arm.comply("fx", 0.5)  # nothing is touched: the arm goes where it pushes
    arm.wait(lift(arm))
    assert (arm.status.comply, arm.status.complying) == ("fx", "fx")
    arm.sleep(0.2)
    assert arm.complied[0] > 1e-3
    arm.lock("fx")
    arm.mode("back", segment_time=0.6, acceleration_time=0.1, stop_on_distance={"rz": 3.0})
    arm.wait(arm.move("up", "back"))
    assert arm.status.complying == ""
    assert arm.complied == (0.0,) * 6
    assert arm.guard is None
    down = arm.transform("down", Transform.translation(0.0, 0.0, -0.03) @ arm.pose)
    arm.position("down again", arm.t6 == down)
    words = {"dx": 0.02, "dy": 0.02, "dz": 0.02}
    arm.mode("feel", segment_time=0.6, acceleration_time=0.1, stop_on_distance=words)
    sequence = arm.move("down again", "feel")
    arm.wait(sequence)
    assert arm.guard is not None
    assert arm.guard.startswith(f"move {sequence}: d")
    with pytest.raises(MoveError, match=r"the bias fx 900 takes .* Nm of joint"):
        arm.move("up", arm.mode("hard", **PUSHES))


# --- errors ------------------------------------------------------------------------------------


def unknown_position(arm: Arm) -> None:
    arm.mode("slow", segment_time=0.5, acceleration_time=0.1)
    arm.move("nowhere", "slow")


def unknown_transform(arm: Arm) -> None:
    a = arm.transform("a", Transform.identity())
    arm.remove(a)
    arm.position("b", arm.t6 == a)


def no_rotation(arm: Arm) -> None:
    arm.transform("skew", Transform.identity()._replace(nx=2.0))


def out_of_range(arm: Arm) -> None:
    arm.joint_position("wound", (*arm.joints[:5], 8.0))


def contradiction(arm: Arm) -> None:
    arm.mode("odd", segment_time=1.0, speed=0.1, acceleration_time=0.1)


def out_of_reach(arm: Arm) -> None:
    far = arm.transform("far", Transform.translation(2.0, 0.0, 0.0))
    arm.position("there", arm.t6 == far)
    arm.mode("slow", segment_time=0.5, acceleration_time=0.1)
    arm.move("there", "slow")


@pytest.mark.parametrize(
    ("asks", "error", "reason"),
    [
        (unknown_position, ProgramError, "'nowhere'"),
        (unknown_transform, EquationError, "position 'b': transform 'a' is not defined"),
        (no_rotation, TransformError, "transform 'skew' is not a rotation"),
        (out_of_range, JointPositionError, "'wound': joint 6 of puma260 at 8 rad .458.366 deg. is"),
        (contradiction, ModeError, "mode 'odd': a segment time of 1 s and speed"),
        (out_of_reach, MoveError, "'there' with 'slow'.* reach is"),
    ],
)
def test_refusals_are_the_exceptions_they_were(
    arm: Arm, asks: Callable[[Arm], None], error: type[ProgramError], reason: str
) -> None:
    with pytest.raises(error, match=reason) as caught:
        asks(arm)
    assert type(caught.value) is error
    arm.sleep(0.004)  # and the conversation goes on


def test_every_error_a_server_names_comes_back_as_itself() -> None:
    for name, kind in ERRORS.items():
        error = error_of(Refusal(name, "why"))
        assert (type(error), kind.__name__, str(error)) == (kind, name, "why")


def test_what_a_refusal_offers_comes_back_with_it() -> None:
    remedy: dict[str, float | str | None] = {"segment_time": 0.82, "config": None}
    sent = msgspec.msgpack.encode(Refusal("MoveError", "why", remedy))
    error = error_of(msgspec.msgpack.decode(sent, type=Refusal))
    assert isinstance(error, MoveError)
    assert error.remedy == remedy


@pytest.mark.parametrize("name", ["NewError", "SystemExit", "KeyboardInterrupt", ""])
def test_an_error_that_is_not_known_is_a_program_error(name: str) -> None:
    error = error_of(Refusal(name, "why"))
    assert type(error) is ProgramError
    assert str(error) == "why"


def test_a_fault_ends_a_wait_and_all_that_follows(bench: ServerBench, arm: Arm) -> None:
    arm.sleep(0.04)
    bench.emergency("guard", "a hand in the cell")
    waits: tuple[Callable[[], None], ...] = (arm.wait, lambda: arm.sleep(1.0), arm.stop)
    for asks in waits:
        with pytest.raises(FaultError, match="emergency stop by 'guard': 'a hand in the cell'"):
            asks()


# --- replies that do not come ------------------------------------------------------------------


@pytest.mark.parametrize("lost", ["lose", "lose_replies"])
def test_a_request_without_a_reply_is_sent_again_and_processed_once(
    socket: CoreSocket, arm: Arm, lost: str
) -> None:
    assert lift(arm) == 1
    socket.lose, socket.lose_replies = (2, 0) if lost == "lose" else (0, 2)
    assert arm.move("up", "slow") == 2
    again = [one.serial for one in socket.sent if one.serial == socket.sent[-1].serial]
    assert len(again) == 3
    assert arm.move("up", "slow") == 3
    assert socket.bench.server.numbers().repeated == (0 if lost == "lose" else 2)
    moves = [one for one in socket.requests if isinstance(one, MoveRequest)]
    assert len(moves) == 3


def test_a_server_that_is_silent_is_given_up_once(socket: CoreSocket, arm: Arm) -> None:
    socket.deaf = True
    began = socket.now()
    with pytest.raises(LinkError, match=r"'bench' has not answered for 5 s: .*rfms serve"):
        arm.move("up", "slow")
    assert socket.now() - began == pytest.approx(ANSWER_S)
    with pytest.raises(LinkError, match="has not answered"):
        arm.stop()
    assert socket.now() - began == pytest.approx(ANSWER_S), "not waited for again"
    for look in (lambda: arm.status, lambda: arm.time, lambda: arm.pose):
        with pytest.raises(LinkError, match="has not answered"):
            look()  # what it told last is not the state any more


def test_a_server_that_dies_during_a_wait_is_noticed(socket: CoreSocket, arm: Arm) -> None:
    arm.sleep(0.04)
    socket.deaf = True
    with pytest.raises(LinkError, match="has not answered"):
        arm.sleep(100.0)


def test_nonsense_is_a_link_error(socket: CoreSocket, arm: Arm) -> None:
    socket.garble = b"\xc1nonsense"
    with pytest.raises(LinkError, match="server 'bench' sent an invalid reply"):
        arm.stop()


def test_what_the_server_could_not_read_is_told_where_it_was_asked(
    socket: CoreSocket, arm: Arm
) -> None:
    """Its reply has no number: it must not wait for the next wait to be told."""
    refusal = Refusal("LinkError", "a message that cannot be read")
    socket.garble = msgspec.msgpack.encode(Reply(UNREAD, arm.status, None, refusal))
    with pytest.raises(LinkError, match="a message that cannot be read"):
        arm.stop()
    arm.sleep(0.004)  # and the conversation goes on


def test_a_server_that_says_nothing_at_first(socket: CoreSocket) -> None:
    socket.deaf = True
    link = RemoteLink(socket, "cell", 1.0, now=socket.now)
    everything: tuple[Callable[[], object], ...] = (link.status, link.time, link.acquire)
    for asks in everything:
        with pytest.raises(LinkError, match="has not answered"):
            asks()


# --- the lease ---------------------------------------------------------------------------------


def test_a_long_wait_renews_the_lease(bench: ServerBench, socket: CoreSocket) -> None:
    link = RemoteLink(socket, "cell", 0.5, now=socket.now)
    link.acquire()
    Arm(link).sleep(6.0)
    renewals = [one for one in socket.requests if isinstance(one, LeaseRequest)]
    assert len(renewals) > 10
    assert bench.now_ns > 5 * SECOND
    assert bench.server.numbers().lapses == 0
    assert bench.server.holder == "cell"


def test_a_lease_that_lapsed_ends_the_program(
    bench: ServerBench, socket: CoreSocket, arm: Arm
) -> None:
    lift(arm)
    arm.sleep(0.02)
    socket.late_ns = 11 * SECOND
    for use in (arm.wait, lambda: arm.move("up", "slow"), lambda: arm.sleep(0.1), arm.wait):
        with pytest.raises(LeaseError, match="'cell' did not renew its lease in time"):
            use()
        assert bench.server.holder is None


def test_another_program_is_refused_by_name(bench: ServerBench, socket: CoreSocket) -> None:
    Coordinator(bench, "left cell").acquire(5.0)
    with pytest.raises(LeaseError, match="controlled by 'left cell'"), connect("bench"):
        raise AssertionError("the arm is not ours")
    assert socket.closed
    assert bench.server.holder == "left cell"


@pytest.mark.system
def test_at_its_end_a_program_has_moved_and_gives_the_arm_back(
    bench: ServerBench, socket: CoreSocket
) -> None:
    with connect("bench", name="cell 1", lease_s=LONG_LEASE_S) as arm:
        assert bench.server.holder == "cell 1"
        lift(arm)
    told = bench.server.status()
    assert (told.lease, told.at_rest, told.completed) == (None, True, 1)
    assert bench.server.numbers().lapses == 0
    assert socket.closed


class MistakeError(Exception):
    """Of a program's own."""


@pytest.mark.system
def test_after_an_exception_the_arm_rests_on_its_way(
    bench: ServerBench, socket: CoreSocket
) -> None:
    with (
        pytest.raises(MistakeError, match="half way"),
        connect("bench", lease_s=LONG_LEASE_S) as arm,
    ):
        start = arm.pose.pz
        lift(arm, 1.0)
        arm.sleep(0.5)
        raise MistakeError("half way")
    told = bench.server.status()
    assert (told.lease, told.at_rest, told.waiting, told.fault) == (None, True, 0, None)
    assert 0.002 < bench.t6.pz - start < 0.028
    assert bench.server.numbers().lapses == 0, "stopped by the program, not by the server"


@pytest.mark.system
def test_whoever_wants_the_program_to_end_gets_an_arm_at_rest(
    bench: ServerBench, socket: CoreSocket
) -> None:
    seen: list[int] = []
    with (
        pytest.raises(KeyboardInterrupt),
        connect(
            "bench",
            lease_s=LONG_LEASE_S,
            interrupted=lambda: len(seen) > 3,
            watch=lambda status: seen.append(status.cycle),
        ) as arm,
    ):
        lift(arm, 2.0)
        arm.wait()
    told = bench.server.status()
    assert (told.lease, told.at_rest, told.fault) == (None, True, None)
    assert seen == sorted(seen)


def test_the_thread_renews_the_lease_while_the_program_computes(
    bench: ServerBench, socket: CoreSocket
) -> None:
    """In real time, so with a lease that is short; what is renewed is counted, not timed."""
    with connect("bench", lease_s=0.1):
        asked = 0
        while asked < 3:
            asked = sum(
                isinstance(one, LeaseRequest) and one.action == "renew" for one in socket.requests
            )
    last = socket.requests[-1]
    assert isinstance(last, LeaseRequest)
    assert last.action == "release"


def test_an_emergency_stop_needs_no_lease(
    bench: ServerBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[bytes] = []
    one = CoreSocket(bench, b"guard")
    one.emergency = taken.append  # type: ignore[attr-defined]
    monkeypatch.setattr("rfms_can.coordinator.connection.ClientSocket", lambda *_: one)
    emergency_stop("bench", name="guard", reason="smoke")
    bench.hear(bench.server.emergency(taken[0]))
    assert bench.server.status().fault == "emergency stop by 'guard': 'smoke'"


# --- reading -----------------------------------------------------------------------------------


def test_a_lease_is_renewed_three_times_in_its_duration() -> None:
    lease = Lease("cell", 1.5)
    assert lease.acquire == LeaseRequest("acquire", "cell", 1.5)
    assert lease.renew == LeaseRequest("renew", "cell", 1.5)
    assert (lease.release.action, lease.release.name) == ("release", "cell")
    assert lease.renewal_s == pytest.approx(0.5)


def test_a_late_status_does_not_set_the_clock_back() -> None:
    """In real time: the status with the least delay tells how the clocks differ."""
    conversation = Conversation("bench")

    def hear(cycle: int, now: float) -> None:
        told = status(cycle=cycle, time=0.004 * cycle, clock="realtime", issued=cycle)
        conversation.hear(msgspec.msgpack.encode(told), now)

    hear(1, 100.014)  # 10 ms late
    assert conversation.time(100.014) == pytest.approx(0.004)
    hear(2, 100.010)  # 2 ms late
    assert conversation.time(100.010) == pytest.approx(0.008)
    hear(10, 100.090)  # 50 ms late
    assert conversation.time(100.090) == pytest.approx(0.088, abs=1e-3)
    hear(9, 100.091)  # an old one
    assert conversation.status.cycle == 10


def test_a_reader_needs_no_lease(bench: ServerBench, socket: CoreSocket) -> None:
    link = RemoteLink(socket, "reader", 1.0, now=socket.now)
    with pytest.raises(LeaseError, match="this session does not control the arm"):
        link.request(MoveRequest("up", "slow"))
    link.wait(AtRest())
    assert unnumbered(link.status()) == unnumbered(bench.server.status())
    assert Query() not in socket.requests


@pytest.mark.parametrize("lost", ["lose", "lose_replies"])
def test_a_wait_that_is_lost_or_whose_reply_is_lost_ends(socket: CoreSocket, lost: str) -> None:
    """A connection that was cut for a moment: the lease is kept, so nothing else would tell."""
    link = RemoteLink(socket, "cell", 1.0, now=socket.now)
    link.acquire()
    arm = Arm(link)
    arm.sleep(0.02)
    before = arm.status.cycle
    setattr(socket, lost, 1)
    arm.sleep(0.1)
    assert arm.status.cycle >= before + 25
    assert len(socket.waits) == 2, "sent again, not asked again"
