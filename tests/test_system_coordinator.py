"""Programs over real sockets: Unix and TCP with keys, both twins, an emergency stop beside them."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.server import Running, free_port

from rfms_can.coordinator import (
    Arm,
    AsyncArm,
    ClientKeys,
    FaultError,
    LeaseError,
    LinkError,
    Transform,
    connect,
    connect_async,
    emergency_stop,
)
from rfms_can.link.address import checked
from rfms_can.link.keys import ServerKeys, new_client_keys, new_server_keys
from rfms_can.rig.serve import Listening
from rfms_can.rig.settings import RunSettings

pytestmark = pytest.mark.system

SETTINGS = RunSettings(friction="none")


@pytest.fixture
def running(runtime: Path) -> Iterator[Running]:
    with Running(SETTINGS, Listening("cell")) as server:
        yield server


def raised(arm: Arm) -> float:
    """Lift the hand by 30 mm; how far it went, m."""
    before = arm.pose
    there = arm.transform("there", Transform.translation(0.0, 0.0, 0.03) @ before)
    up = arm.position("up", arm.t6 == there)
    slow = arm.mode("slow", segment_time=0.5, acceleration_time=0.1)
    arm.wait(arm.move(up, slow))
    return arm.pose.pz - before.pz


def test_a_program_over_unix_sockets(running: Running) -> None:
    with connect("cell", name="program") as arm:
        assert raised(arm) == pytest.approx(0.03, abs=1e-3)
        assert arm.status.lease == "program"
        with pytest.raises(LeaseError, match="controlled by 'program'"), connect("cell"):
            raise AssertionError("the arm is taken")
    with connect("cell", name="the next") as arm:  # with names of its own
        assert raised(arm) == pytest.approx(0.03, abs=1e-3)


def test_a_program_over_tcp_with_keys(runtime: Path) -> None:
    public = new_server_keys(runtime / "keys")
    secret = new_client_keys(runtime / "keys", "desk")
    keys = ClientKeys.load(secret, public)
    port = free_port()
    listening = Listening("cell", checked("127.0.0.1", port), ServerKeys.load(runtime / "keys"))
    with (
        Running(SETTINGS, listening),
        connect(f"tcp://127.0.0.1:{port}", keys=keys) as arm,
    ):
        assert raised(arm) == pytest.approx(0.03, abs=1e-3)


def test_nobody_at_a_tcp_address(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rfms_can.coordinator.remote.ANSWER_S", 0.2)
    address = f"tcp://127.0.0.1:{free_port()}"
    with pytest.raises(LinkError, match=rf"'{address}' has not answered"), connect(address):
        raise AssertionError("there is no arm")


def test_an_emergency_stop_from_elsewhere_ends_a_program(running: Running) -> None:
    with pytest.raises(FaultError, match="by 'guard': 'a hand'"), connect("cell") as arm:
        arm.sleep(0.1)
        emergency_stop("cell", name="guard", reason="a hand")
        arm.sleep(1000.0)


def test_a_server_that_ends_ends_a_program(runtime: Path) -> None:
    server = Running(SETTINGS, Listening("cell"))
    with pytest.raises(LinkError), connect("cell") as arm:
        server.end()
        arm.sleep(1.0)


def test_parts_of_a_program_over_unix_sockets(running: Running) -> None:
    heights: list[float] = []

    async def lift(arm: AsyncArm) -> None:
        there = await arm.transform("there", Transform.translation(0.0, 0.0, 0.03) @ arm.pose)
        up = await arm.position("up", arm.t6 == there)
        slow = await arm.mode("slow", segment_time=0.5, acceleration_time=0.1)
        await arm.wait(await arm.move(up, slow))

    async def watch(arm: AsyncArm) -> None:
        while arm.status.completed < 1:
            heights.append(arm.pose.pz)
            await arm.sleep(0.1)

    async def main() -> None:
        async with connect_async("cell", name="parts") as arm:
            begin = arm.status.cycle
            await arm.run(lift(arm), watch(arm))
            assert (arm.status.cycle - begin) % 25 == 0, "watched every 0.1 s, to the cycle"

    asyncio.run(main())
    assert heights[-1] - heights[0] > 0.02
    assert heights == sorted(heights)
