"""Injectors of the rig and of a program's requests: each does what it says."""

import random
from collections.abc import Iterator
from typing import Any

import pytest

from rfms_can.errors import RfmsError
from rfms_can.faults import requests, stations
from rfms_can.faults.catalogue import inject
from rfms_can.faults.context import Context
from rfms_can.faults.forge import Forge
from rfms_can.faults.site import Site
from rfms_can.faults.table import State
from rfms_can.faults.warm import FAR, MODE, WarmSystem
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.protection import Receiver
from rfms_can.wire.records import Dac, Sync

JOINT = 3
PERIOD_NS = 4_000_000


def site_on(rig: SimulatedRig, *program: object) -> Site:
    context = Context(
        arm=rig.master.arm,
        period_ns=PERIOD_NS,
        wire=rig.master.wire,
        forge=Forge(rig.master.wire),
        draw=random.Random(1),
        node=JOINT,
        now_ns=lambda: rig.bus.now_ns,
        touch=lambda *_: None,
    )
    return Site(rig, context, *program)  # type: ignore[arg-type]


@pytest.fixture
def site() -> Site:
    """On a system at power-up."""
    return site_on(SimulatedRig(RunSettings()))


@pytest.fixture
def heard(site: Site) -> list[tuple[Frame, str]]:
    """Frames and their senders."""
    seen: list[tuple[Frame, str]] = []
    site.rig.bus.observers.append(lambda _, frame, sender: seen.append((frame, sender)))
    return seen


def after(site: Site, periods: float) -> None:
    bus = site.rig.bus
    bus.run_until(bus.now_ns + round(periods * PERIOD_NS))


def test_a_controller_that_is_bus_off(site: Site, heard: list[tuple[Frame, str]]) -> None:
    stations.bus_off(site)
    assert site.effect_ns == 0
    after(site, 20)
    assert {sender for _, sender in heard} >= {"joint 1", "plant"}
    assert "joint 3" not in {sender for _, sender in heard}


@pytest.mark.parametrize("once", [True, False])
def test_a_full_queue(site: Site, heard: list[tuple[Frame, str]], once: bool) -> None:
    (stations.full_once if once else stations.full_for_ever)(site)
    after(site, 0.2)
    assert site.controller(JOINT).tx_overflow > 0, "its announcement is lost"
    assert site.effect_ns is not None
    after(site, 1000)
    assert ("joint 3" in {sender for _, sender in heard}) == once


@pytest.mark.parametrize("once", [True, False])
def test_a_late_master(site: Site, once: bool) -> None:
    deadline_ns = site.rig.master.next_deadline_ns() or 0
    (stations.late_once if once else stations.late_for_ever)(site)
    assert site.effect_ns == deadline_ns
    late_ns = round(stations.LATE * PERIOD_NS)
    assert site.controller(MASTER).latency_ns == late_ns
    after(site, 300)
    assert site.controller(MASTER).latency_ns == (0 if once else late_ns)


def test_strangers(site: Site, heard: list[tuple[Frame, str]]) -> None:
    stations.flood(site)
    after(site, 2)
    of_flood = [frame for frame, sender in heard if sender == "stranger"]
    assert {frame.id for frame in of_flood} == {stations.FLOOD_ID}
    assert len(of_flood) == 2 * PERIOD_NS // stations.FLOOD_NS
    assert site.rig.bus.statistics.load(site.rig.bus.now_ns) > 0.8
    known = {codec.id for codec in site.context.wire.codecs.values()}
    assert stations.FLOOD_ID not in known


@pytest.mark.parametrize(
    ("put_in", "record", "node"),
    [(stations.foreign_sync, Sync, None), (stations.foreign_dac, Dac, JOINT)],
)
def test_foreign_frames_are_good_ones(
    site: Site, heard: list[tuple[Frame, str]], put_in: object, record: type[Any], node: int | None
) -> None:
    assert callable(put_in)
    put_in(site)
    after(site, 3)
    receiver: Receiver[Any] = site.context.wire.receiver(record, node)
    taken = [receiver.take(frame) for frame, sender in heard if sender == "stranger"]
    assert len(taken) >= 2
    assert None not in taken


def test_second_nodes_have_the_number_but_not_the_name(
    site: Site, heard: list[tuple[Frame, str]]
) -> None:
    stations.second_joint(site)
    stations.second_master(site)
    after(site, 100)
    senders = {sender for _, sender in heard}
    assert {"second joint 3", "second master", "joint 3", "master"} <= senders
    assert site.effect_ns is not None


def test_a_seized_brake_holds_against_the_motor(site: Site) -> None:
    physics = site.rig.plant.physics
    stations.seized_brake(site)
    before = physics.true_q
    for _ in range(20):
        physics.step_period([2000] * 6, [0] * 6)
    moved = [abs(a - b) for a, b in zip(physics.true_q, before, strict=True)]
    assert moved[JOINT - 1] == 0.0
    assert all(way > 0.0 for joint, way in enumerate(moved, 1) if joint != JOINT)


def test_a_program_is_there_in_the_campaign_alone(site: Site) -> None:
    with pytest.raises(RfmsError, match="rfms faults"):
        requests.too_many(site)


@pytest.fixture(scope="module")
def moving() -> Iterator[WarmSystem]:
    warm = WarmSystem("puma260", State.MOVING)
    warm.begin()
    warm.run_to(0)
    yield warm


@pytest.mark.system
@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("ask_unreachable", "out of reach"),
        ("ask_no_rotation", "rotation"),
        ("redefine_position", "outside its range"),
        ("redefine_mode", "stroke"),
        ("ask_malformed", "message"),
        ("ask_too_many", "moves wait already"),
    ],
)
def test_requests_are_refused_for_the_reason_they_are_made_for(
    moving: WarmSystem, name: str, reason: str
) -> None:
    site = site_on(moving.rig, moving.program, FAR, MODE)
    inject(name, site)
    assert site.refused is not None
    assert reason in site.refused
