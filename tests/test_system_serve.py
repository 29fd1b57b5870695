"""A server with real sockets on the simulated bus: two clients, one killed, garbage, its end."""

import os
import random
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
import zmq
from support.server import LONG_S, Running
from support.system import ROOT

from rfms_can.errors import LinkError
from rfms_can.link.address import endpoints_of, socket_paths
from rfms_can.link.client import ClientSocket
from rfms_can.messages import (
    MAX_BYTES,
    CycleReached,
    LeaseRequest,
    MoveOutcome,
    MoveOver,
    Outcome,
    OutcomeQuery,
    Query,
    ResetRequest,
    StopRequest,
    TransformMessage,
    WaitRequest,
)
from rfms_can.rig.serve import Listening, serve
from rfms_can.rig.settings import RunSettings
from rfms_can.transform import Transform

pytestmark = pytest.mark.system

SETTINGS = RunSettings(friction="none")


@pytest.fixture
def running(runtime: Path) -> Iterator[Running]:
    with Running(SETTINGS, Listening("bench")) as server:
        yield server


def test_a_move_over_the_link(running: Running) -> None:
    client = running.client("cell")
    client.acquire()
    before = client.ask(Query()).status
    sequence = client.move()
    reply = client.wait(MoveOver(sequence))
    assert reply.refusal is None
    assert reply.status.completed == sequence
    assert reply.status.t6[11] - before.t6[11] == pytest.approx(0.05, abs=1e-3)
    cycle = client.ask(Query()).status.cycle
    assert cycle == reply.status.cycle, "time stands still between two waits"
    broadcast = client.watch(lambda status: status.cycle == cycle)
    assert broadcast.lease == "cell"
    server = client.done(Query("server")).server
    assert server is not None
    assert sum(server.latency_cycles[2:]) == 0
    assert server.latency_cycles[1] == 2  # TRANSFORM and REQUEST
    client.done(LeaseRequest("release"))
    served = running.end()
    assert served.fault is None
    assert served.result.incomplete == 0


def test_two_clients_one_is_refused_by_name(running: Running) -> None:
    left, right = running.client("left cell"), running.client("right cell")
    left.acquire()
    for message in (TransformMessage("a", Transform.identity()), StopRequest()):
        refusal = right.refused(message)
        assert refusal.error == "LeaseError"
        assert "controlled by 'left cell'" in refusal.reason
    cycle = right.ask(Query()).status.cycle + 3
    waiting = right.send(WaitRequest([CycleReached(cycle)]))
    assert left.wait(CycleReached(cycle + 3)).refusal is None
    assert right.reply(waiting).status.cycle == cycle


KILLED = """
import sys, time
sys.path.insert(0, "tests")
from support.server import Client
from rfms_can.messages import LeaseRequest, MoveOver, WaitRequest
client = Client("bench", "killed")
client.acquire(0.5)
sequence = client.move(seconds=60.0, z=0.08)
client.send(WaitRequest([MoveOver(sequence)]))
print("moves", flush=True)
while True:
    client.send(LeaseRequest("renew", duration_s=0.5))
    time.sleep(0.05)
"""


def test_a_client_killed_in_mid_motion(running: Running) -> None:
    watcher = running.client("watcher")
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "moves\n"
        watcher.watch(lambda status: status.stage == "LINEAR" and status.lease == "killed")
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
    status = watcher.watch(lambda status: status.lease is None)
    assert status.fault is None
    status = watcher.watch(lambda status: status.at_rest)
    assert (status.phase, status.fault, status.waiting) == ("RUN", None, 0)
    assert status.completed == 1, "it is over"
    (outcome,) = watcher.done(OutcomeQuery(1, 1)).outcomes
    assert outcome == MoveOutcome(1, Outcome.LAPSED, "'killed' did not renew its lease")
    watcher.acquire()  # the arm can be had again
    watcher.done(LeaseRequest("release"))
    assert running.end().numbers.lapses == 1


def test_an_emergency_stop_from_a_third_client(running: Running) -> None:
    left, right, third = (running.client(name) for name in ("left", "right", "third"))
    left.acquire()
    sequence = left.move(seconds=20.0)
    waiting = left.send(WaitRequest([MoveOver(sequence)]))
    right.watch(lambda status: status.stage == "LINEAR")
    third.emergency("a hand in the cell")
    fault = "emergency stop by 'third': 'a hand in the cell'"
    refusal = left.reply(waiting).refusal
    assert refusal is not None
    assert (refusal.error, refusal.reason) == ("FaultError", fault)
    assert right.watch(lambda status: status.fault is not None).fault == fault
    assert left.refused(ResetRequest()).error == "FaultError"
    served = running.end()
    assert str(served.fault) == fault
    assert served.numbers.emergencies == 1


def test_the_end_tells_who_waits_and_brakes(running: Running) -> None:
    client = running.client("cell")
    client.acquire()
    sequence = client.move(seconds=10.0)
    waiting = client.send(WaitRequest([MoveOver(sequence)]))
    client.watch(lambda status: status.stage == "LINEAR")
    serving = running.serving
    served = running.end()
    assert served.fault is None
    assert serving is not None
    assert serving.session.master.ended
    assert all(serving.session.master.arm_state.braked)
    assert waiting == client.serial


def test_a_name_is_served_once(running: Running) -> None:
    with pytest.raises(LinkError, match="'bench' is running already"):
        serve(SETTINGS, Listening("bench"))


# --- garbage ----------------------------------------------------------------------------------

GREETING = b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(16) + b"\x00" + bytes(31)


def garbage() -> Iterator[bytes]:
    """What is said to a Unix socket by who does not speak ZMTP, or does so badly."""
    rng = random.Random(5)
    yield b""
    yield b"GET / HTTP/1.1\r\nHost: arm\r\n\r\n"
    yield b"\x00" * 1000
    yield b"\xff" * 1_000_000
    yield GREETING[:10]
    yield GREETING[:40]
    yield GREETING
    yield GREETING[:10] + b"\x09" + GREETING[11:]
    yield GREETING + b"\x04\x05READY"
    yield GREETING + b"\x06" + (2**62).to_bytes(8, "big") + b"\x05READY"  # a command without end
    ready = b"\x05READY\x0bSocket-Type\x00\x00\x00\x06DEALER\x08Identity\x00\x00\x00\x00"
    hello = GREETING + b"\x04" + bytes([len(ready)]) + ready
    yield hello + b"\x00\x05abc"  # half a message
    yield hello + b"\x02" + (2**63 - 1).to_bytes(8, "big") + b"x"  # one of 8 EiB
    yield hello + b"\x02" + (1_000_000).to_bytes(8, "big") + bytes(1_000_000)
    yield hello + b"\x01\x01x" * 5000  # parts without end
    for _ in range(60):
        data = bytearray(hello + b"\x00\x20" + rng.randbytes(32))
        for _ in range(rng.randrange(1, 8)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        yield bytes(data[: rng.randrange(1, len(data) + 1)])
        yield rng.randbytes(rng.randrange(1, 4000))


def shout(path: Path, data: bytes) -> None:
    """Say something to a Unix socket and leave, whatever it makes of it."""
    with socket.socket(socket.AF_UNIX) as raw:
        raw.settimeout(2.0)
        raw.connect(str(path))
        try:
            raw.sendall(data)
            raw.recv(64)
        except OSError:
            return


def test_garbage_on_raw_sockets(running: Running) -> None:
    client = running.client("cell")
    client.acquire(10.0)
    sequence = client.move()
    before = client.ask(Query()).status
    for path in socket_paths("bench"):
        for data in garbage():
            shout(path, data)
    after = client.ask(Query()).status
    assert after.refused > 0, "some of it was well-formed ZMTP"
    assert msgspec.structs.replace(after, refused=before.refused, issued=before.issued) == before
    assert client.wait(MoveOver(sequence)).status.completed == sequence
    assert running.client("other").ask(Query()).status.fault is None


def test_messages_that_are_none(running: Running) -> None:
    """Too long ones end the connection, short ones are refused; others notice nothing."""
    client = running.client("cell")
    endpoints = endpoints_of("bench")
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    with context.socket(zmq.DEALER) as rude, context.socket(zmq.PUSH) as push:
        for socket_ in (rude, push):
            socket_.linger = 0
        rude.connect(endpoints.requests)
        push.connect(endpoints.emergency)
        for size in (MAX_BYTES + 1, 1_000_000, 20_000_000):
            rude.send(bytes(size))
            push.send(bytes(size))
        rude.send_multipart([b"a", b"b", b"c"])
        rude.send(b"")
        refused = 0
        while refused < 2:
            assert rude.poll(int(LONG_S * 1000)), "each is refused with a reason"
            reply = msgspec.msgpack.decode(rude.recv())
            assert reply["refusal"]["error"] == "LinkError"
            assert reply["serial"] == 0
            refused += 1
        push.send(b"stop!")
        push.send_multipart([b"a", b"b"])
        status = client.ask(Query()).status
        assert (status.fault, status.phase) == (None, "RUN")
    context.term()


def test_clients_that_come_and_go(running: Running) -> None:
    for number in range(100):
        with ClientSocket("bench") as one:
            one.send(b"x" * number)
    client = running.client("cell")
    assert client.ask(Query()).status.phase == "RUN"
