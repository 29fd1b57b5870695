"""``rfms serve`` as a user starts it: nine processes on the hub, clients in others, signals."""

import json
import os
import signal
from pathlib import Path

import pytest
from support.command_line import assert_none_left, end
from support.server import LONG_S, Client, ServeProcess

from rfms_can.errors import LinkError
from rfms_can.messages import (
    CycleReached,
    LeaseRequest,
    MoveOver,
    Outcome,
    OutcomeQuery,
    Query,
    WaitRequest,
)

pytestmark = pytest.mark.processes


@pytest.fixture(autouse=True)
def directory(runtime: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(runtime)


def test_a_move_in_lockstep_and_the_end(runtime: Path) -> None:
    with ServeProcess("--bus", "hub:serve", "--friction", "none") as server:
        client = Client("rfms", "cell")
        client.acquire()
        sequence = client.move(seconds=1.0)
        reply = client.wait(MoveOver(sequence))
        assert reply.refusal is None
        cycle = reply.status.cycle
        assert client.ask(Query()).status.cycle == cycle, "time stands still for a while"
        on = client.ask(WaitRequest([CycleReached(cycle + 1)])).status
        assert on.cycle == cycle + 1
        # who thinks too long is not waited for: nodes would miss SYNC
        later = client.watch(lambda status: status.cycle > cycle + 20)
        assert later.fault is None
        assert later.at_rest
        numbers = client.done(Query("server")).server
        assert numbers is not None
        assert numbers.unattended >= 10
        assert numbers.latency_cycles == [0, 2, 0, 0]  # TRANSFORM and REQUEST
        client.done(LeaseRequest("release"))
        client.close()
        os.kill(server.process.pid, signal.SIGTERM)
        ended = end(server.process)
        assert ended.code == 0, ended
        result = json.loads(ended.out)
        assert result["fault"] is None
        assert result["incomplete"] == 0
        assert result["server"]["unattended"] >= 10
        assert_none_left(server.process.pid)
    with pytest.raises(LinkError, match="no server 'rfms' is running"):
        Client("rfms")


def test_real_time_goes_on_by_itself(runtime: Path) -> None:
    """25 Hz, so that a busy machine keeps up; a lapse stops the arm, a signal brakes it."""
    with ServeProcess("--bus", "hub:serve", "--clock", "realtime", "--rate", "25") as server:
        client, watcher = Client("rfms", "cell"), Client("rfms", "watcher")
        client.acquire(1.0)
        before = watcher.status().cycle
        client.move(seconds=30.0)
        assert watcher.watch(lambda status: status.cycle > before + 5).fault is None
        stopped = watcher.watch(lambda status: status.lease is None)
        assert stopped.fault is None
        rested = watcher.watch(lambda status: status.at_rest)
        assert (rested.phase, rested.completed) == ("RUN", 1)
        (outcome,) = watcher.done(OutcomeQuery(1, 1)).outcomes
        assert outcome.how is Outcome.LAPSED
        numbers = watcher.done(Query("server")).server
        assert numbers is not None
        assert numbers.lapses == 1
        assert sum(numbers.latency_ns) == sum(numbers.latency_cycles) == 2
        client.close()
        watcher.close()
        os.kill(server.process.pid, signal.SIGINT)
        ended = end(server.process)
        assert ended.code == 0, ended
        assert json.loads(ended.out)["fault"] is None


def test_an_emergency_stop_ends_it_with_one_line(runtime: Path) -> None:
    with ServeProcess("--bus", "hub:serve", "--clock", "realtime", "--rate", "25") as server:
        client, third = Client("rfms", "cell"), Client("rfms", "third")
        client.acquire(5.0)
        waiting = client.send(WaitRequest([MoveOver(client.move(seconds=30.0))]))
        third.watch(lambda status: status.stage == "LINEAR")
        third.emergency("smoke")
        refusal = client.reply(waiting).refusal
        assert refusal is not None
        assert refusal.reason == "emergency stop by 'third': 'smoke'"
        ended = end(server.process)
        assert ended.code == 1
        assert ended.err.splitlines() == ["rfms: emergency stop by 'third': 'smoke'"]
        for one in (client, third):
            one.close()
        assert_none_left(server.process.pid, within_s=LONG_S)
