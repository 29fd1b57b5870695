"""``rfms serve`` and ``rfms keys`` as a user types them."""

import json
import os
import signal
import threading
import time
from functools import partial
from pathlib import Path

import pytest
from support.command_line import Rfms
from support.server import Client, free_port

from rfms_can.cli.serve import grants_of, latency_lines
from rfms_can.errors import LinkError
from rfms_can.link.client import ClientSocket
from rfms_can.link.keys import ClientKeys
from rfms_can.messages import LeaseRequest, MoveOver, Query, ServerNumbers


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--keys", "k"], "--keys works only with TCP connections: give --tcp PORT"),
        (["--tcp", "5000", "--bind", "0.0.0.0"], "is not loopback: others would move the arm"),
        (["--tcp", "5000", "--bind", "::"], "is not loopback"),
        (["--tcp", "5000", "--bind", "robot"], "is not numerical"),
        (["--tcp", "65534"], "three in a row"),
        (["--tcp", "5000", "--keys", "k"], "server.key_secret is not a key"),
        (["--name", "../up"], "server name '../up'"),
        (["--grant", "camera"], "--grant 'camera': give SENSOR=REFERENCE,REFERENCE"),
        (["--grant", "=part"], "--grant '=part': give SENSOR=REFERENCE,REFERENCE"),
        (["--grant", "camera=part,"], "each of 1 to 64 characters, as in camera=part"),
        (["--grant", "camera=" + ",".join("abc" * 11)], "33 references for sensor 'camera', 32"),
        ([a for k in range(17) for a in ("--grant", f"s{k}=part")], "17 sensors, 16 may be"),
    ],
)
def test_what_cannot_be_served_is_said_in_one_line(
    rfms: Rfms, arguments: list[str], reason: str
) -> None:
    assert reason in rfms("serve", *arguments).complaint


def test_grants_of_one_sensor_add_up() -> None:
    assert grants_of(["camera=part, tray", "probe=tip", "camera=lid"]) == {
        "camera": ["part", "tray", "lid"],
        "probe": ["tip"],
    }


def test_keys_let_a_client_in(rfms: Rfms, tmp_path: Path) -> None:
    ended = rfms("keys", "k", "--client", "cell")
    assert ended.code == 0
    assert "k/server.key: the server's public key" in ended.out
    assert "k/cell.key_secret: keys of 'cell'" in ended.out
    assert "is there already" in rfms("keys", "k", "--client", "cell").complaint
    assert "client name" in rfms("keys", "k", "--client", "../up").complaint
    keys = ClientKeys.load(tmp_path / "k" / "cell.key_secret", tmp_path / "k" / "server.key")
    assert len(keys.public) == len(keys.secret) == len(keys.server) == 40


def in_the_meantime(talk: "partial[None]") -> threading.Thread:
    """Talk to the server of this process from another thread, then end it with a signal."""

    def run() -> None:
        try:
            talk()
        finally:
            os.kill(os.getpid(), signal.SIGTERM)

    thread = threading.Thread(target=run)
    thread.start()
    return thread


def connected() -> Client:
    """A client, as soon as there is a server and its arm is enabled."""
    while True:
        try:
            client = Client("rfms", "cell")
        except LinkError:
            time.sleep(0.01)
            continue
        while (refusal := client.ask(LeaseRequest("acquire", "cell", 5.0)).refusal) is not None:
            assert refusal.error == "LeaseError"
            assert refusal.reason.startswith("the arm is not enabled (phase ")
        return client


@pytest.mark.system
def test_serving_until_a_signal(rfms: Rfms, tmp_path: Path) -> None:
    def talk() -> None:
        client = connected()
        client.wait(MoveOver(client.move(seconds=0.5)))
        client.done(LeaseRequest("release"))
        client.close()

    thread = in_the_meantime(partial(talk))
    ended = rfms("serve", "--friction", "none", "--record", tmp_path / "record")
    thread.join()
    assert ended.code == 0, ended
    assert "rfms: 'cell' controls the arm" in ended.err
    assert "rfms: 'cell' gave the arm back" in ended.err
    assert "from request to SETPOINT: 2 one cycle on" in ended.err
    assert json.loads((tmp_path / "record" / "summary.json").read_text())["fault"] is None
    assert (tmp_path / "record" / "bus.log").stat().st_size > 100_000


@pytest.mark.system
def test_json_and_tcp_with_keys(rfms: Rfms, tmp_path: Path) -> None:
    rfms("keys", "k", "--client", "cell")
    keys = ClientKeys.load(tmp_path / "k" / "cell.key_secret", tmp_path / "k" / "server.key")
    port = free_port()

    def talk() -> None:
        client = connected()
        client.socket.close()
        client.socket = ClientSocket(f"tcp://127.0.0.1:{port}", keys)
        client.done(LeaseRequest("release"))  # the same session on another socket
        client.close()

    thread = in_the_meantime(partial(talk))
    ended = rfms("serve", "--json", "--tcp", str(port), "--bind", "0.0.0.0", "--keys", "k")
    thread.join()
    ready, result = (json.loads(line) for line in ended.out.splitlines())
    assert ready == {"ready": "rfms"}
    assert result["server"]["requests"] >= 2
    assert result["server"]["latency_cycles"] == [0, 0, 0, 0]


@pytest.mark.system
def test_an_emergency_stop_is_the_one_line(rfms: Rfms) -> None:
    def talk() -> None:
        client = connected()
        client.ask(Query())
        client.emergency("smoke")
        client.watch(lambda status: status.fault is not None)
        client.close()

    thread = in_the_meantime(partial(talk))
    ended = rfms("serve", "--friction", "none", "--json")
    thread.join()
    assert ended.code == 1
    assert ended.complaint == "rfms: emergency stop by 'cell': 'smoke'"


def test_the_histogram_shows_every_bin() -> None:
    times = [0] * 12
    times[3], times[11] = 30, 10
    numbers = ServerNumbers(1, 40, 0, 0, 0, 0, 0, [0, 39, 1, 0], times, 40_000_000)
    lines = list(latency_lines(numbers))
    assert lines[0] == "from request to SETPOINT: 39 one cycle on, 1 two cycles on"
    assert lines[1].split() == ["under", "4", "ms", "30", "#" * 30]
    assert lines[2].split() == ["more", "10", "#" * 10]
    assert lines[3].split() == ["longest", "40.00", "ms"]
