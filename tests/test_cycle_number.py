"""The number of a cycle goes on from 0 after the largest that SYNC carries: 25 days at 2 kHz."""

from collections.abc import Callable

import pytest
from support.fleet import Fleet
from support.system import SHORT

from rfms_can.master.phases import Phase
from rfms_can.master.server.latency import Latency
from rfms_can.rig.program import load_program
from rfms_can.rig.result import RunResult
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import LAST_CYCLE, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Sync

BEFORE = 200
"""Cycles of a run before the largest number: homing takes less, the program more."""


def run(prepare: Callable[[SimulatedRig], None]) -> tuple[RunResult, list[float], list[int]]:
    """The short program: its result, where the arm ended, the numbers of its cycles."""
    rigs: list[SimulatedRig] = []
    numbers: list[int] = []
    wire = Wire()
    identifier, decode = wire.id(Sync), wire.receiver(Sync).decoder.decode

    def look(_: int, frame: Frame) -> None:
        sync = decode(frame) if frame.id == identifier else None
        if isinstance(sync, Sync):
            numbers.append(sync.cycle)

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        rigs.append(rig)
        rig.observe(look)
        prepare(rig)

    result = execute(load_program(SHORT), RunSettings(), watch=watch).result
    return result, list(rigs[0].plant.physics.true_q), numbers


def late(rig: SimulatedRig) -> None:
    """Let cycles begin shortly before the largest number."""
    rig.master.cycle.first = LAST_CYCLE - BEFORE
    rig.master.cycle.number = rig.master.cycle.first - 1


@pytest.mark.system
def test_a_run_passes_the_largest_number_as_any_other_cycle() -> None:
    usual, q_usual, _ = run(lambda _: None)
    passing, q_passing, numbers = run(late)
    enabled = len(numbers) - 1 - numbers[::-1].index(LAST_CYCLE - BEFORE)
    assert numbers[enabled + BEFORE : enabled + BEFORE + 3] == [LAST_CYCLE, 0, 1]
    assert passing.fault is None
    assert (passing.cycles, passing.incomplete, passing.lost) == (usual.cycles, 0, 0)
    assert passing.joints == usual.joints
    assert q_passing == pytest.approx(q_usual, abs=1e-9)


@pytest.mark.parametrize("lost", [LAST_CYCLE - 1, LAST_CYCLE, 0, 1])
def test_a_sync_lost_about_the_largest_number_stops_nothing(wire: Wire, lost: int) -> None:
    fleet = Fleet(wire)
    fleet.master.cycle.first = LAST_CYCLE - BEFORE
    fleet.master.cycle.number = fleet.master.cycle.first - 1
    fleet.enable()
    deaf, sync, number = fleet.joints[1], wire.id(Sync), 0

    def fate(frame: Frame, to: object) -> bool:
        nonlocal number
        here = frame.id == sync and to is deaf and fleet.master.cycle.number == lost
        number += here
        return here

    fleet.pump.lose(fate)
    fleet.run(BEFORE + 40)
    assert number == 1
    assert fleet.master.cycle.number < LAST_CYCLE - BEFORE
    assert fleet.master.phase is Phase.RUN
    assert fleet.master.fault is None


def test_a_request_across_the_largest_number_is_as_quick_as_any(wire: Wire) -> None:
    fleet = Fleet(wire).enable()
    latency = Latency(fleet.master)
    fleet.master.cycle.number = LAST_CYCLE - 1
    latency.taken(0)
    fleet.run(4)
    latency.look()
    assert fleet.master.cycle.number < LAST_CYCLE
    assert sum(latency.cycles) == 1
    assert latency.cycles[-1] == 0
