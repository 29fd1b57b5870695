"""When brakes close and open: at power-up, with the first frame, after three silent cycles."""

from rfms_can.plant.brake_watchdog import SILENT_CYCLES, BrakeWatchdog


def test_a_brake_follows_its_own_node_alone() -> None:
    brakes = BrakeWatchdog(2)
    assert [brakes.closed(board) for board in (0, 1)] == [True, True]
    brakes.release(0)
    assert [brakes.closed(board) for board in (0, 1)] == [False, True]
    closes = [brakes.miss(0) for _ in range(SILENT_CYCLES + 2)]
    assert closes == [False] * (SILENT_CYCLES - 1) + [True, False, False]
    assert brakes.closed(0)


def test_all_brakes_close_at_once_and_open_one_by_one() -> None:
    brakes = BrakeWatchdog(3)
    for board in range(3):
        brakes.release(board)
    brakes.close_all()
    assert all(brakes.closed(board) for board in range(3))
    brakes.release(1)
    assert [brakes.closed(board) for board in range(3)] == [True, False, True]
