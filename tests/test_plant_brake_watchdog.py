"""When brakes close and open: at power-up, with the first frame, after silence, after RESET."""

import pytest

from rfms_can.plant.brake_watchdog import (
    DEAF_CYCLES,
    SILENT_CYCLES,
    SPEECHLESS_CYCLES,
    BrakeWatchdog,
)

BOARDS = 4
ALL = [True] * BOARDS
NONE = [False] * BOARDS


@pytest.fixture
def brakes() -> BrakeWatchdog:
    """Four boards, three of them joints, open."""
    brakes = BrakeWatchdog(BOARDS, 3)
    assert closed(brakes) == ALL
    assert brakes.end_cycle(ALL, driven=True) == []
    return brakes


def closed(brakes: BrakeWatchdog) -> list[bool]:
    return [brakes.closed(board) for board in range(BOARDS)]


def test_a_brake_follows_its_own_node_alone(brakes: BrakeWatchdog) -> None:
    heard = [False, True, True, True]
    closing = [brakes.end_cycle(heard, driven=False) for _ in range(SILENT_CYCLES + 2)]
    assert closing == [[]] * (SILENT_CYCLES - 1) + [[0], [], []]
    assert closed(brakes) == [True, False, False, False]
    brakes.end_cycle([True, False, True, True], driven=False)
    assert closed(brakes) == NONE


@pytest.mark.parametrize("gripper", [False, True])
def test_where_no_joint_is_heard_they_are_waited_for(brakes: BrakeWatchdog, gripper: bool) -> None:
    heard = [False, False, False, gripper]
    closing = [brakes.end_cycle(heard, driven=True) for _ in range(SPEECHLESS_CYCLES)]
    assert closing[:-1] == [[]] * (SPEECHLESS_CYCLES - 1)
    assert closing[-1] == [0, 1, 2] if gripper else [0, 1, 2, 3]


def test_one_that_is_heard_alone_is_that_which_the_others_wait_for(brakes: BrakeWatchdog) -> None:
    """Its ERROR is lost on the bus: it has all six itself, and drives on."""
    heard = [False, True, False, True]
    closing = [brakes.end_cycle(heard, driven=True) for _ in range(SPEECHLESS_CYCLES)]
    assert closing == [[]] * (SPEECHLESS_CYCLES - 1) + [[0, 2]]


@pytest.mark.parametrize("driven", [False, True])
def test_a_plant_that_hears_nothing_at_all_doubts_itself_first(
    brakes: BrakeWatchdog, driven: bool
) -> None:
    bound = DEAF_CYCLES if driven else SPEECHLESS_CYCLES
    closing = [
        brakes.end_cycle(NONE, driven=driven, synchronised=False) for _ in range(DEAF_CYCLES)
    ]
    assert closing.index([0, 1, 2, 3]) == bound - 1


def test_joints_that_speak_without_sync_are_braked_as_with_it(brakes: BrakeWatchdog) -> None:
    heard = [False, True, True, True]
    closing = [
        brakes.end_cycle(heard, driven=True, synchronised=False) for _ in range(SILENT_CYCLES)
    ]
    assert closing == [[]] * (SILENT_CYCLES - 1) + [[0]]


def test_one_that_goes_on_being_silent_when_others_speak_is_closed(brakes: BrakeWatchdog) -> None:
    for _ in range(SPEECHLESS_CYCLES - 1):
        brakes.end_cycle(NONE, driven=True)
    assert brakes.end_cycle([False, True, True, True], driven=True) == [0]


@pytest.mark.parametrize("driven", [False, True])
def test_a_lost_node_opens_nothing_until_reset(brakes: BrakeWatchdog, driven: bool) -> None:
    for _ in range(SILENT_CYCLES):
        brakes.end_cycle([False, True, True, True], driven=driven)
    assert brakes.lost(0) == driven
    brakes.start()
    brakes.end_cycle(ALL, driven=True)
    assert closed(brakes) == [driven, False, False, False]
    brakes.reset()
    brakes.end_cycle(ALL, driven=True)
    assert closed(brakes) == NONE


def test_a_brake_that_was_closed_all_along_is_none_of_a_lost_node() -> None:
    brakes = BrakeWatchdog(BOARDS, 3)
    for _ in range(10):
        assert brakes.end_cycle(NONE, driven=True) == []
    assert not any(brakes.lost(board) for board in range(BOARDS))


def test_start_forgets_silence(brakes: BrakeWatchdog) -> None:
    for _ in range(SPEECHLESS_CYCLES - 1):
        brakes.end_cycle(NONE, driven=False)
    brakes.start()
    assert brakes.end_cycle(NONE, driven=True) == []
    assert closed(brakes) == NONE


def test_all_brakes_close_at_once_and_open_one_by_one(brakes: BrakeWatchdog) -> None:
    brakes.close_all()
    assert closed(brakes) == ALL
    brakes.end_cycle([False, True, False, False], driven=True)
    assert closed(brakes) == [True, False, True, True]


def test_silence_counts_from_nothing_at_power_up_and_after_start() -> None:
    for begin in (lambda brakes: None, BrakeWatchdog.start):
        brakes, silence = BrakeWatchdog(BOARDS, 3), [False, True, True, True]
        brakes.end_cycle(silence, driven=True)
        brakes.end_cycle(ALL, driven=True)
        begin(brakes)
        closing = [brakes.end_cycle(silence, driven=True) for _ in range(SILENT_CYCLES)]
        assert closing == [[]] * (SILENT_CYCLES - 1) + [[0]]
