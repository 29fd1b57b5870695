"""Single edges of the safety core that mutants showed no other test to ask."""

import numpy as np
import pytest
from support.joint_bench import JointBench

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.detectors.runaway import RunawayWatch
from rfms_can.joint_nodes.detectors.sensors import SensorWatch
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.master.verification import AGREEMENT, CYCLES, Verification
from rfms_can.node.port_counts import PortCounts, tell_port
from rfms_can.plant.board import Board
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS, MASTER
from rfms_can.wire.records import Config, Heartbeat
from rfms_can.wire.vocabulary import NodeState, Parameter

P = Parameter
EXACT = {
    **all_parameters(PUMA_260, "corke", 0.004)[2],
    **{P.PERIOD: 2.0**-8, P.SPEED_LIMIT: 0.0, P.TACHOMETER_LIMIT: 1.0},
}
"""Of numbers whose sums are exact."""


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_difference_at_its_bound_is_borne_and_the_next_is_not(sign: float) -> None:
    watch = SensorWatch(EXACT)
    assert not watch.differ(sign * 3.0 * 2.0**-8, 0.0, 0.0)
    assert watch.differ(sign * 2.0**-20, 0.0, 0.0)


def test_a_node_without_a_configuration_has_no_master_to_keep(wire: Wire) -> None:
    """It hears a bus that is driven, and another master: there is nothing to take over."""
    bench = JointBench(wire)
    bench.sync(NodeState.OPERATIONAL)
    frame = bench.sender(Config, bench.number).frame(Parameter.PERIOD, 0, 0.004, 0)
    for boot_id in (7, 8):
        bench.say(Heartbeat, MASTER, 1, 0, 0, boot_id, wire.dbc_hash, 0, 0, 0)
        assert len(bench.give(frame)) == 1, "an old frame, after another boot"
    assert bench.node.ignored == {}


def test_a_node_that_tells_no_counts_is_given_none() -> None:
    class Silent:
        __slots__ = ()

    tell_port(Silent(), PortCounts)  # type: ignore[arg-type]


def test_a_board_drives_no_more_than_its_limit_with_both_dacs() -> None:
    board = Board(PUMA_260, 0, 0.0)
    assert board.set_dacs(2047, 2047) == board.set_dacs(2047)
    assert board.set_dacs(-2048, -2048) == board.set_dacs(-2048)


@pytest.mark.parametrize(("share", "cycles"), [(0.9, 5), (1.1, 2)])
@pytest.mark.parametrize("fastest", [0.25, 4.0])
def test_how_fast_a_runaway_is_fast_goes_with_the_speed_limit(
    share: float, cycles: int, fastest: float
) -> None:
    watch = RunawayWatch({**EXACT, P.SPEED_LIMIT: fastest}, 5)
    away = share * 0.5 * fastest * EXACT[P.PERIOD]
    found = [watch.watch(9.0 + k * away, -k * away) for k in range(1, cycles + 1)]
    assert found == [False] * (cycles - 1) + [True]


@pytest.mark.parametrize(
    ("gain", "fastest", "bound"),
    [(0.0, 99.0, 0.1), (100.0, 99.0, 0.05), (1.0, 99.0, 0.1), (1.0, 4.0, 0.04)],
)
def test_a_runaway_counts_from_the_least_of_three_errors(
    gain: float, fastest: float, bound: float
) -> None:
    limits = {
        P.FOLLOWING_ERROR_LIMIT: 0.2,
        P.TORQUE_LIMIT: 10.0,
        P.KP: gain,
        P.SPEED_LIMIT: fastest,
    }
    assert RunawayWatch({**EXACT, **limits}, 5).bound == pytest.approx(bound)


@pytest.mark.parametrize("joint", JOINTS)
def test_of_an_arm_that_complies_and_is_where_it_should_be_an_untrue_error_is_found(
    joint: int,
) -> None:
    verification = Verification(all_parameters(PUMA_260, "corke", 0.004))
    zero = (0.0,) * 6
    told = tuple(3.0 * AGREEMENT * (k == joint) for k in JOINTS)
    for _ in range(CYCLES):
        fault = verification.check(zero, None, zero, told, 0b111111, np.eye(6))
    assert fault is not None and fault.culprit.frame == f"ERROR_{joint}"


def test_an_arm_that_is_off_by_its_bounds_everywhere_and_tells_more_is_found() -> None:
    verification = Verification(all_parameters(PUMA_260, "corke", 0.004))
    at = verification.bounds
    for _ in range(CYCLES):
        fault = verification.check(at, None, (0.0,) * 6, tuple(2.0 * each for each in at))
    assert fault is not None
