"""Programs in real time: time goes on while they compute, and parts wait each for itself.

At 25 Hz, so that a busy machine keeps up; the arm is not moved, and not waited for to rest.
"""

import asyncio
import os
import signal
import time
from collections.abc import Iterator
from itertools import pairwise

import pytest
from support.command_line import end
from support.server import ServeProcess

from rfms_can.coordinator import Arm, AsyncArm, TransformError
from rfms_can.coordinator.aio_remote import AsyncRemoteLink
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.link.aio import AsyncClientSocket
from rfms_can.link.client import ClientSocket

pytestmark = pytest.mark.processes

REALTIME = ("--bus", "hub:programs", "--clock", "realtime", "--rate", "25", "--friction", "none")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServeProcess]:
    directory = tmp_path_factory.mktemp("server")
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.chdir(directory)
        monkeypatch.setenv("XDG_RUNTIME_DIR", str(directory))
        with ServeProcess(*REALTIME) as command:
            yield command
            os.kill(command.process.pid, signal.SIGTERM)
            ended = end(command.process)
            assert ended.code == 0, ended


def test_the_servers_time_goes_on_and_stamps_observations(server: ServeProcess) -> None:
    with ClientSocket("rfms") as socket:
        link = RemoteLink(socket, "program", 1.0)
        link.acquire()
        arm = Arm(link)
        assert arm.status.clock == "realtime"
        part = arm.reference("part", arm.pose)
        times = [arm.time]
        while times[-1] < times[0] + 0.4:  # it goes on without a wait
            time.sleep(0.01)
            told = arm.status
            times.append(arm.time)
            assert times[-1] >= told.time, "what was told has been"
            arm.observe(part, arm.pose, at=times[-1])
        assert times == sorted(times)
        with pytest.raises(TransformError, match="in the future"):
            arm.observe(part, arm.pose, at=arm.time + 1.0)
        link.release()


def test_parts_wait_each_for_itself(server: ServeProcess) -> None:
    beats: list[int] = []

    async def beat(arm: AsyncArm) -> None:
        for _ in range(5):
            await arm.sleep(0.08)
            beats.append(arm.status.cycle)

    async def busy(arm: AsyncArm) -> int:
        while len(beats) < 5:  # never waits for the arm
            await asyncio.sleep(0.005)
        return arm.status.cycle

    async def main() -> None:
        async with AsyncClientSocket("rfms") as socket:
            link = AsyncRemoteLink(socket, "parts", 1.0)
            await link.acquire()
            arm = AsyncArm(link)
            begin = arm.status.cycle
            _, _, cycle = await arm.run(beat(arm), arm.sleep(0.2), busy(arm))
            assert cycle - begin >= 10
            assert arm.time >= arm.status.time
            await link.release()

    asyncio.run(main())
    assert all(later - sooner >= 2 for sooner, later in pairwise(beats))
