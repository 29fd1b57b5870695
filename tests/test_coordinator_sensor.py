"""The program of a sensor, and the coordinator's grant to it, over a server's own core."""

import asyncio
import math
from collections.abc import Callable
from typing import Any

import pytest
from support.link import AsyncCoreSocket, CoreSocket, FakeLink, status
from support.server import SECOND, Coordinator, ServerBench

from rfms_can.coordinator import Arm, AsyncArm, Sensor, connect_sensor
from rfms_can.coordinator.aio_remote import AsyncRemoteLink
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.errors import LeaseError, ProgramError, TransformError
from rfms_can.master.server.core import Server
from rfms_can.messages import (
    CycleReached,
    GrantRequest,
    SensorRequest,
    TransformMessage,
    WaitRequest,
)
from rfms_can.rig.session import Session
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire

HOME = Transform.identity()
THERE = Transform.translation(0.1, 0.0, 0.0)


@pytest.fixture
def bench(wire: Wire) -> ServerBench:
    bench = ServerBench(wire)
    bench.server = Server(bench.master, {"camera": ["part"]})
    return bench


@pytest.fixture
def socket(bench: ServerBench, monkeypatch: pytest.MonkeyPatch) -> CoreSocket:
    """The socket ``connect_sensor`` gets."""
    one = CoreSocket(bench, b"camera")
    monkeypatch.setattr("rfms_can.coordinator.sensor.ClientSocket", lambda *_: one)
    return one


@pytest.fixture
def cell(bench: ServerBench) -> Coordinator:
    return Coordinator(bench, "cell").acquire(10.0)


# --- the sensor ---------------------------------------------------------------------------------


def test_a_sensor_observes_and_leaves(
    bench: ServerBench, socket: CoreSocket, cell: Coordinator
) -> None:
    with connect_sensor(name="camera", alive_s=10.0) as camera:
        camera.observe("part", HOME, predict="velocity", rest_after=0.4)
        camera.observe("part", THERE, at=camera.time, twist=(0.1, 0.0, 0.0, 0.0, 0.0, 0.0))
        assert camera.status.sensors == {"camera": "live"}
    assert socket.closed
    attach, first, second, detach = socket.requests
    assert attach == SensorRequest("attach", "camera", 10.0)
    assert first == TransformMessage("part", HOME, "reference", predict="velocity", rest_after=0.4)
    assert isinstance(second, TransformMessage)
    assert (second.predict, second.rest_after, second.stamp) == (None, None, 0.0)
    assert detach == SensorRequest("detach", "camera")
    assert cell.query().sensors == {"camera": "granted"}
    with pytest.raises(ProgramError, match="had ended"):
        camera.observe("part", HOME)


def test_a_sensor_waits_for_a_coordinator(
    bench: ServerBench, socket: CoreSocket, monkeypatch: pytest.MonkeyPatch
) -> None:
    naps: list[float] = []

    def nap(seconds: float) -> None:
        naps.append(seconds)
        if len(naps) == 3:
            Coordinator(bench, "cell").acquire(10.0)

    monkeypatch.setattr("rfms_can.coordinator.sensor.time.sleep", nap)
    with connect_sensor(name="camera", alive_s=10.0) as camera:
        with pytest.raises(LeaseError, match="no coordinator controls the arm after 0 s: start"):
            camera.wait_for_coordinator(within=0.0)
        with pytest.raises(LeaseError, match="observes nothing, as no coordinator controls"):
            camera.observe("part", HOME)
        camera.wait_for_coordinator()
        camera.observe("part", HOME)
    assert len(naps) == 3


def test_a_sensor_waits_for_its_grant(
    bench: ServerBench, socket: CoreSocket, cell: Coordinator, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nap(_: float) -> None:
        cell.done(GrantRequest("probe", ["tip"]))

    with (
        pytest.raises(LeaseError, match="sensor 'probe' has no grant, or no longer"),
        connect_sensor(name="probe", patience_s=0.0),
    ):
        raise AssertionError
    assert socket.closed
    monkeypatch.setattr("rfms_can.coordinator.sensor.time.sleep", nap)
    with connect_sensor(name="probe", alive_s=10.0) as probe:
        probe.observe("tip", HOME)


def test_a_sensor_sleeps_on_the_arms_clock(
    bench: ServerBench, socket: CoreSocket, cell: Coordinator
) -> None:
    assert cell.ask(WaitRequest([CycleReached(1000)])) is None
    with connect_sensor(name="camera", alive_s=10.0) as camera:
        before = camera.status.cycle
        camera.sleep(0.02)
        assert camera.status.cycle == before + 5
        with pytest.raises(ProgramError, match=r"sleep of -1 s: give a time"):
            camera.sleep(-1)


def test_the_end_of_the_coordinator_ends_its_sleep(
    bench: ServerBench, socket: CoreSocket, cell: Coordinator
) -> None:
    with connect_sensor(name="camera", alive_s=10.0) as camera:
        bench.now_ns += 11 * SECOND
        with pytest.raises(LeaseError, match="no coordinator controls the arm"):
            camera.sleep(1.0)


@pytest.mark.parametrize(
    ("use", "complaint"),
    [
        (lambda c: c.observe("part", "here"), "transform 'part': a Transform is needed"),
        (lambda c: c.observe("", HOME), "transform '': name ''"),
        (lambda c: c.observe("part", HOME, at="now"), "stamp 'now'"),
        (lambda c: c.observe("part", HOME, twist=(1.0,)), "twist"),
        (lambda c: c.observe("part", HOME, predict="guess"), "predict 'guess'"),
        (lambda c: c.observe("part", HOME, rest_after=0.1), "rest_after 0.1"),
        (lambda c: c.observe("part", HOME, rest_after=math.nan), "rest_after nan"),
        (lambda c: c.observe("part", HOME, at=1e3), "in the future"),
        (lambda c: c.observe("part", HOME._replace(nx=2.0)), "is not a rotation"),
    ],
)
def test_bad_observations_are_refused_in_one_line(
    bench: ServerBench,
    socket: CoreSocket,
    cell: Coordinator,
    use: Callable[[Sensor], None],
    complaint: str,
) -> None:
    with connect_sensor(name="camera", alive_s=10.0) as camera:
        with pytest.raises((TransformError, ProgramError)) as caught:
            use(camera)
        assert complaint in str(caught.value)
        assert "\n" not in str(caught.value)
    assert not bench.master.motion.world.names().transforms


@pytest.mark.parametrize(
    "settings",
    [{"name": ""}, {"name": "c" * 65}, {"alive_s": 0.0}, {"alive_s": 11.0}, {"patience_s": -1.0}],
)
def test_bad_settings_of_a_sensor_are_refused_before_it_connects(
    socket: CoreSocket, settings: dict[str, Any]
) -> None:
    with (
        pytest.raises(ProgramError, match=r"^sensor '.*"),
        connect_sensor(**{"name": "camera", **settings}),
    ):
        raise AssertionError
    assert not socket.sent


# --- the coordinator's grant --------------------------------------------------------------------


@pytest.fixture
def arm(bench: ServerBench) -> Arm:
    link = RemoteLink(CoreSocket(bench, b"program"), "program", 10.0)
    link.acquire()
    return Arm(link)


def test_a_coordinator_grants_and_revokes(bench: ServerBench, arm: Arm) -> None:
    part = arm.reference("tray", HOME)
    arm.grant("probe", [part, "tip"])
    assert arm.status.sensors == {"camera": "granted", "probe": "granted"}
    probe = Coordinator(bench, "probe")
    probe.done(SensorRequest("attach", "probe", 10.0))
    arm.grant("probe", [part], within=1.0)
    assert arm.status.sensors["probe"] == "live"
    probe.done(TransformMessage("tray", THERE, "reference"))
    arm.grant("probe", [])
    assert arm.status.sensors == {"camera": "granted"}


def test_a_sensor_that_does_not_come_is_named(arm: Arm) -> None:
    with pytest.raises(ProgramError) as caught:
        arm.grant("probe", ["tip"], within=0.1)
    assert str(caught.value) == (
        "sensor 'probe' has not connected within 0.1 s (it is granted): start its program, with "
        "connect_sensor"
    )


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("probe", "tip"), "references 'tip' is one text; give a list of names"),
        (("", ["tip"]), "sensor ''"),
        (("probe", [""]), "references"),
        (("probe", [f"r{k}" for k in range(33)]), "length <= 32"),
        (("probe", ["tip"], -1.0), "within -1.0 s, 0 to 3600 may be"),
        (("probe", ["tip"], math.nan), "within nan s, 0 to 3600 may be"),
    ],
)
def test_bad_grants_are_refused_in_one_line(
    arm: Arm, arguments: tuple[Any, ...], complaint: str
) -> None:
    with pytest.raises(ProgramError, match=r"^grant to sensor '") as caught:
        arm.grant(*arguments)
    assert complaint in str(caught.value)
    assert arm.status.sensors == {"camera": "granted"}


def test_coroutines_grant_too(bench: ServerBench) -> None:
    async def main() -> None:
        link = AsyncRemoteLink(AsyncCoreSocket(CoreSocket(bench, b"program")), "program", 10.0)
        await link.acquire()
        arm = AsyncArm(link)
        await arm.grant("probe", ["tip"])
        assert arm.status.sensors["probe"] == "granted"
        with pytest.raises(ProgramError, match="has not connected within"):
            await arm.grant("probe", ["tip"], within=0.1)
        await link.release()

    asyncio.run(main())


def test_in_one_process_there_is_nothing_to_connect_to(wire: Wire) -> None:
    rig = SimulatedRig(RunSettings(friction="none"), wire)
    session = Session(rig)
    session.bring_up()
    with pytest.raises(ProgramError, match="use rfms serve and connect"):
        Arm(session.link).grant("camera", ["part"])
    session.disable()


def test_a_grant_is_one_message() -> None:
    link = FakeLink()
    Arm(link).grant("camera", ["part", "tray"])
    assert link.heard == [GrantRequest("camera", ["part", "tray"])]
    assert status().sensors == {}
