"""Sensors on the server's core: what they may do, by whose grant, and what their silence does."""

import pytest
from support.server import SECOND, Coordinator, ServerBench

from rfms_can.master.server.core import Server
from rfms_can.master.trajectory.goal import Moment
from rfms_can.messages import (
    AnyRequest,
    CycleReached,
    GrantRequest,
    GripperRequest,
    LeaseRequest,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    Query,
    SensorRequest,
    StopRequest,
    TransformMessage,
    WaitRequest,
    Weave,
)
from rfms_can.messages.sensors import MAX_SENSORS
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire

HOME = Transform.identity()
PART = TransformMessage("part", HOME, "reference")


def wait(bench: ServerBench, cycles: int) -> WaitRequest:
    """A wait for some cycles from now."""
    return WaitRequest([CycleReached(bench.server.status().cycle + cycles)])


@pytest.fixture
def bench(wire: Wire) -> ServerBench:
    return ServerBench(wire)


@pytest.fixture
def cell(bench: ServerBench) -> Coordinator:
    return Coordinator(bench, "cell").acquire(2.0)


@pytest.fixture
def camera(bench: ServerBench, cell: Coordinator) -> Coordinator:
    """A sensor that may observe ``part`` and ``tray``."""
    cell.done(GrantRequest("camera", ["part", "tray"]))
    sensor = Coordinator(bench, "camera")
    sensor.done(SensorRequest("attach", "camera", 1.0))
    return sensor


def place(bench: ServerBench, name: str) -> Transform:
    """Where a reference is in the next cycle."""
    motion = bench.master.motion
    transform = motion.world._transforms.table[name]
    assert not isinstance(transform, Transform)
    return transform.at(Moment(motion.generator.tick_count))


# --- what it may do -----------------------------------------------------------------------------


def test_a_sensor_observes_what_it_was_granted(
    bench: ServerBench, cell: Coordinator, camera: Coordinator
) -> None:
    cell.done(TransformMessage("part", HOME, "reference", predict="hold"))
    there = Transform.translation(0.1, 0.2, 0.3)
    camera.done(TransformMessage("part", there, "reference", stamp=camera.query().time))
    assert place(bench, "part") == there
    assert camera.query().sensors == {"camera": "live"}


def test_it_may_define_a_reference_first(
    bench: ServerBench, cell: Coordinator, camera: Coordinator
) -> None:
    camera.done(TransformMessage("tray", HOME, "reference", predict="velocity", rest_after=0.5))
    cell.done(PositionMessage("at tray", ["t6"], ["tray"]))
    assert place(bench, "tray") == HOME


@pytest.mark.parametrize(
    ("message", "asked"),
    [
        (StopRequest(), "STOP"),
        (MoveRequest("there", "there"), "REQUEST"),
        (ModeMessage("m", "joint", 0.2, 1.0), "MODE"),
        (PositionMessage("p", ["t6"], ["part"]), "POSITION"),
        (GripperRequest(opens=True), "GRIPPER"),
        (GrantRequest("camera", ["tool"]), "GRANT"),
        (LeaseRequest("acquire", "camera"), "LEASE"),
        (LeaseRequest("release"), "LEASE"),
        (TransformMessage("part", HOME), "TRANSFORM of kind value"),
        (
            TransformMessage("part", HOME, "functional", Weave((0.0, 0.0, 0.1), 1.0)),
            "TRANSFORM of kind functional",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_and_nothing_else(
    bench: ServerBench, camera: Coordinator, message: AnyRequest, asked: str
) -> None:
    before = bench.server.status()
    refusal = camera.refused(message)
    assert refusal.error == "LeaseError"
    assert refusal.reason == (
        f"sensor 'camera' may observe references and nothing else, it asked for {asked}: "
        f"let a coordinator ask, in a session of its own"
    )
    after = bench.server.status()
    assert (after.lease, after.sequence, after.waiting) == ("cell", 0, 0)
    assert after.sensors == before.sensors
    world = camera.done(Query("world")).world
    assert world is not None
    assert not world.transforms


def test_another_reference_is_refused_with_those_that_are_granted(camera: Coordinator) -> None:
    refusal = camera.refused(TransformMessage("tool", HOME, "reference"))
    assert refusal.reason == (
        "sensor 'camera' may observe 'part', 'tray', not 'tool': the coordinator may grant it with "
        "arm.grant, the server with --grant"
    )


def test_what_is_wrong_with_an_observation_is_said_as_to_a_coordinator(
    cell: Coordinator, camera: Coordinator
) -> None:
    cell.done(TransformMessage("part", HOME))
    cell.done(TransformMessage("tray", HOME, "reference"))
    assert "of kind value and stays so" in camera.refused(PART).reason
    late = TransformMessage("tray", HOME, "reference", stamp=camera.query().time + 1.0)
    assert "in the future" in camera.refused(late).reason


# --- by whose grant -----------------------------------------------------------------------------


def test_without_a_grant_it_is_told_who_may_give_one(bench: ServerBench, cell: Coordinator) -> None:
    cell.done(GrantRequest("probe", ["tip"]))
    camera = Coordinator(bench, "camera")
    refusal = camera.refused(SensorRequest("attach", "camera"))
    assert refusal.error == "LeaseError"
    assert refusal.reason == (
        "sensor 'camera' has no grant, or no longer: the coordinator gives it with "
        "arm.grant('camera', [...]), the server with --grant camera=REFERENCE; sensors with one: "
        "'probe'"
    )
    assert "this session is not sensor" in camera.refused(SensorRequest("renew", "camera")).reason
    assert camera.refused(PART).error == "LeaseError"
    assert camera.query().sensors == {"probe": "granted"}


def test_only_the_holder_of_the_lease_grants(bench: ServerBench, cell: Coordinator) -> None:
    other = Coordinator(bench, "other")
    assert other.refused(GrantRequest("camera", ["part"])).error == "LeaseError"
    assert other.query().sensors == {}


def test_a_grant_is_revoked(bench: ServerBench, cell: Coordinator, camera: Coordinator) -> None:
    assert camera.ask(wait(bench, 1000)) is None
    cell.done(GrantRequest("camera", []))
    bench.hear(bench.server.look(bench.now_ns))
    ended = bench.inbox[camera.peer][-1].refusal
    assert ended is not None, "it does not wait in vain"
    assert "has no grant, or no longer" in ended.reason
    for message in (PART, wait(bench, 1), SensorRequest("renew", "camera")):
        assert "has no grant, or no longer" in camera.refused(message).reason
    assert camera.query().sensors == {}


@pytest.mark.parametrize("lapses", [False, True], ids=["released", "lapsed"])
def test_a_grant_ends_with_the_session_of_the_coordinator(
    bench: ServerBench, cell: Coordinator, camera: Coordinator, lapses: bool
) -> None:
    if lapses:
        bench.now_ns += 3 * SECOND
    else:
        cell.done(LeaseRequest("release"))
    assert "has no grant, or no longer" in camera.refused(PART).reason
    cell.acquire()
    assert "has no grant, or no longer" in camera.refused(PART).reason
    cell.done(GrantRequest("camera", ["part"]))
    camera.done(PART)


def test_the_grant_of_the_server_lasts_but_needs_a_coordinator(bench: ServerBench) -> None:
    bench.server = Server(bench.master, {"camera": ["part"]})
    camera = Coordinator(bench, "camera")
    camera.done(SensorRequest("attach", "camera", 10.0))
    refusal = camera.refused(PART)
    assert refusal.reason == (
        "sensor 'camera' observes nothing, as no coordinator controls the arm: wait until one does "
        "(lease in the status)"
    )
    for name in ("one", "another"):
        cell = Coordinator(bench, name).acquire()
        camera.done(PART)
        assert camera.ask(wait(bench, 1000)) is None
        cell.done(LeaseRequest("release"))
        bench.hear(bench.server.look(bench.now_ns))
        ended = bench.inbox[camera.peer][-1].refusal
        assert ended is not None, "it does not wait in vain"
        assert ended.reason == refusal.reason
        for message in (PART, wait(bench, 1)):
            assert camera.refused(message).error == "LeaseError"


def test_the_coordinator_may_grant_more_than_the_server(bench: ServerBench) -> None:
    bench.server = Server(bench.master, {"camera": ["part"]})
    cell = Coordinator(bench, "cell").acquire()
    cell.done(GrantRequest("camera", ["part", "tray"]))
    camera = Coordinator(bench, "camera")
    camera.done(SensorRequest("attach", "camera", 10.0))
    camera.done(TransformMessage("tray", HOME, "reference"))
    cell.done(GrantRequest("camera", []))
    camera.done(PART)
    assert camera.refused(TransformMessage("tray", HOME, "reference")).error == "LeaseError"


def test_one_session_at_a_time_has_a_name(bench: ServerBench, camera: Coordinator) -> None:
    other = Coordinator(bench, "another camera")
    refusal = other.refused(SensorRequest("attach", "camera"))
    assert refusal.reason.startswith("sensor 'camera' is another session, for 1.00 s yet")
    bench.now_ns += SECOND
    other.done(SensorRequest("attach", "camera"))
    assert camera.refused(PART).error == "LeaseError"
    other.done(PART)


def test_who_controls_the_arm_is_no_sensor(cell: Coordinator, camera: Coordinator) -> None:
    cell.done(GrantRequest("probe", ["part"]))
    refusal = cell.refused(SensorRequest("attach", "probe"))
    assert "this session controls the arm and may observe anyway" in refusal.reason
    cell.done(PART)


def test_sensors_are_bounded_in_number(cell: Coordinator) -> None:
    for k in range(MAX_SENSORS):
        cell.done(GrantRequest(f"camera {k}", ["part"]))
    refusal = cell.refused(GrantRequest("one more", ["part"]))
    assert f"one of {MAX_SENSORS + 1} with a grant, {MAX_SENSORS} may be" in refusal.reason


# --- its silence --------------------------------------------------------------------------------


def test_silence_is_told_and_brings_what_it_observed_to_rest(
    bench: ServerBench, cell: Coordinator, camera: Coordinator
) -> None:
    twist = (0.0, 0.1, 0.0, 0.0, 0.0, 0.0)
    moving = TransformMessage("part", HOME, "reference", predict="velocity", twist=twist)
    camera.done(moving)
    bench.now_ns += SECOND
    cell.done(Query())
    assert bench.server.status().sensors == {"camera": "silent"}
    assert bench.server.events[-1] == (
        "sensor 'camera' has said nothing for 1 s; not observed: 'part', 'tray'"
    )
    bench.cycles(round(0.2 / 0.004) + 1)
    rest = place(bench, "part")
    assert 0.0 < rest.py < 0.015
    bench.cycles(20)
    assert place(bench, "part") == rest
    camera.done(PART)
    assert bench.server.status().sensors == {"camera": "live"}
    assert bench.server.events[-1] == "sensor 'camera' is back"


def test_whatever_it_says_keeps_it_alive(bench: ServerBench, camera: Coordinator) -> None:
    for message in (
        Query(),
        PART,
        SensorRequest("renew", "camera"),
        SensorRequest("renew", "camera"),
    ):
        camera.done(message)
        bench.now_ns += SECOND // 2 - 1
    bench.server.look(bench.now_ns)
    assert bench.server.status().sensors == {"camera": "live"}
    camera.done(SensorRequest("detach", "camera"))
    assert bench.server.status().sensors == {"camera": "granted"}
    assert bench.server.events[-1].startswith("sensor 'camera' has left")


def test_time_passes_while_both_wait(
    bench: ServerBench, cell: Coordinator, camera: Coordinator
) -> None:
    assert cell.ask(wait(bench, 10)) is None
    assert not bench.server.time_may_pass, "the sensor computes"
    assert camera.ask(wait(bench, 5)) is None
    assert bench.run(lambda: False) == 5, "and now again"
    bench.now_ns += SECOND
    cell.done(LeaseRequest("renew", duration_s=2.0))
    assert bench.server.time_may_pass, "a silent sensor keeps no one"
    assert bench.run(lambda: False) == 5
