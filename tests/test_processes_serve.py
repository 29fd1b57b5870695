"""``rfms serve`` as a user starts it: nine processes on the hub, clients in others, signals."""

import json
import os
import signal
from pathlib import Path

import pytest
from support.command_line import (
    assert_none_left,
    at_a_terminal,
    end,
    kill,
    processes_of,
    start,
)
from support.server import LONG_S, Client, ServeProcess

from rfms_can.errors import LinkError
from rfms_can.messages import (
    CycleReached,
    Enabled,
    LeaseRequest,
    MoveOver,
    Outcome,
    OutcomeQuery,
    Query,
    ResetRequest,
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


def test_an_emergency_stop_halts_it_until_a_person_lifts_it(runtime: Path) -> None:
    with ServeProcess("--bus", "hub:serve", "--clock", "realtime", "--rate", "25") as server:
        client, third = Client("rfms", "cell"), Client("rfms", "third")
        client.acquire(5.0)
        waiting = client.send(WaitRequest([MoveOver(client.move(seconds=30.0))]))
        third.watch(lambda status: status.stage == "LINEAR")
        third.emergency("smoke")
        refusal = client.reply(waiting).refusal
        assert refusal is not None
        assert refusal.reason == "emergency stop by 'third': 'smoke'"
        client.done(LeaseRequest("release"))
        refused = end(start("reset"))
        assert (refused.code, len(refused.err.splitlines())) == (1, 1)
        assert "a person lifts it at the server's command line" in refused.err
        no_person = end(start("reset", "--lift-emergency-stop"))
        assert (no_person.code, "no terminal" in no_person.err) == (1, True)
        assert third.status().emergency, "a program does not lift it"
        stays = at_a_terminal("no\n", "reset", "--lift-emergency-stop")
        assert (stays.code, third.status().emergency) == (1, True)
        lifted = at_a_terminal("lift\n", "reset", "--lift-emergency-stop")
        assert lifted.code == 0, lifted
        assert "emergency stop by 'third': 'smoke'" in lifted.out
        status = third.watch(lambda status: status.phase == "RUN")
        assert (status.fault, status.emergency) == (None, False)
        third.acquire(5.0)
        third.emergency("again")
        third.watch(lambda status: status.fault is not None)
        os.kill(server.process.pid, signal.SIGTERM)
        ended = end(server.process)
        assert ended.code == 1, "it ended halted"
        assert ended.err.splitlines() == ["rfms: emergency stop by 'third': 'again'"]
        assert json.loads(ended.out)["reset_faults"] == ["emergency stop by 'third': 'smoke'"]
        for one in (client, third):
            one.close()
        assert_none_left(server.process.pid, within_s=LONG_S)


def test_a_killed_joint_may_be_replaced_and_the_arm_reset(runtime: Path) -> None:
    """The same server goes on: the joint that was started by hand homes, the others need not."""
    with ServeProcess("--bus", "hub:serve", "--friction", "none") as server:
        client = Client("rfms", "cell")
        client.lease_s = 10.0
        client.acquire()
        waiting = client.send(WaitRequest([MoveOver(client.move(seconds=30.0))]))
        client.watch(lambda status: status.stage == "LINEAR")
        _, _, _, second, *_ = sorted(processes_of(server.process.pid))  # parent, hub, joint 1
        os.kill(second, signal.SIGKILL)
        refusal = client.reply(waiting).refusal
        assert refusal is not None
        assert "joint 2" in refusal.reason
        client.done(ResetRequest())
        again = client.wait(Enabled()).refusal
        assert again is not None
        assert again.reason.startswith("not on the bus: joint 2")
        joint = start("joint", "2", "--bus", "hub:serve")
        try:
            client.done(ResetRequest())
            reply = client.wait(Enabled())
            assert (reply.refusal, reply.status.phase) == (None, "RUN")
            sequence = client.move("on", seconds=1.0, z=0.01)
            assert client.wait(MoveOver(sequence)).status.fault is None
            (outcome,) = client.done(OutcomeQuery(sequence, sequence)).outcomes
            assert outcome.how is Outcome.MADE
        finally:
            kill(joint)
        client.close()
        os.kill(server.process.pid, signal.SIGTERM)
        end(server.process)
