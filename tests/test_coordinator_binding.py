"""Programs that name each pick, and define what they named again: in process and over the link."""

from collections.abc import Callable, Iterator

import pytest
from support.link import CoreSocket, FakeLink
from support.server import ServerBench

from rfms_can.coordinator import Arm, Expression
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.errors import EquationError, ModeError, MoveError, ProgramError, TransformError
from rfms_can.messages import Answer, PlannedMove, RemoveRequest, TransformMessage
from rfms_can.rig.session import Session
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire

TOOL = Transform.translation(0.0, 0.0, 0.1)


@pytest.fixture
def bench(wire: Wire) -> ServerBench:
    return ServerBench(wire)


@pytest.fixture
def socket(bench: ServerBench) -> CoreSocket:
    return CoreSocket(bench, b"program")


@pytest.fixture(params=["in process", "over the link"])
def arm(request: pytest.FixtureRequest, wire: Wire) -> Iterator[Arm]:
    if request.param == "in process":
        session = Session(SimulatedRig(RunSettings(friction="none"), wire))
        session.bring_up()
        yield Arm(session.link)
    else:
        yield Arm(linked(request.getfixturevalue("socket")))


def linked(socket: CoreSocket) -> RemoteLink:
    link = RemoteLink(socket, "cell", 10.0, now=socket.now)
    link.acquire()
    return link


class Cell:
    """A program with a tool, a part 20 mm off, and a mode."""

    def __init__(self, arm: Arm) -> None:
        self.arm = arm
        self.begin = arm.pose
        self.tool = arm.transform("tool", TOOL)
        self.mode = arm.mode("slow", segment_time=0.5, acceleration_time=0.1)
        self.part = self.define("part", 0.0, 0.02)
        self.at_part = arm.position("at part", arm.t6 @ self.tool == self.part)

    def pose(self, x: float, z: float) -> Transform:
        """A place as it is defined, of T6."""
        return self.begin @ Transform.translation(x, 0.0, z)

    def define(self, name: str, x: float, z: float) -> Expression:
        """A place for the tool."""
        return self.arm.transform(name, self.pose(x, z) @ TOOL)

    def reached(self, x: float, z: float) -> bool:
        """Whether the arm is there, within what it follows at rest."""
        self.arm.wait()
        self.arm.sleep(0.1)
        return bool(self.arm.pose == pytest.approx(self.pose(x, z), abs=5e-4))


# --- M12: a value that is redefined ------------------------------------------------------------


@pytest.mark.system
def test_a_value_defined_again_is_where_the_next_move_goes(arm: Arm) -> None:
    cell = Cell(arm)
    arm.move(cell.at_part, cell.mode)
    assert cell.reached(0.0, 0.02)
    cell.define("part", 0.02, 0.02)
    assert cell.reached(0.0, 0.02), "a definition moves nothing"
    arm.move(cell.at_part, cell.mode)
    assert cell.reached(0.02, 0.02)


@pytest.mark.system
def test_a_value_defined_again_changes_the_moves_that_wait_and_not_the_one_under_way(
    arm: Arm,
) -> None:
    cell = Cell(arm)
    other = arm.position("other", arm.t6 @ cell.tool == cell.define("other", 0.0, 0.04))
    first = arm.move(cell.at_part, cell.mode)
    second = arm.move(other, cell.mode)
    arm.sleep(0.2)
    before = arm.plan(second)
    cell.define("part", 0.03, 0.02)  # the first goes there no more: it is under way
    assert arm.plan(second) == before
    cell.define("other", 0.0, 0.0)
    assert arm.plan(second).via_deviation != before.via_deviation
    assert arm.plan(second).segment_time == before.segment_time
    arm.wait(first)
    assert cell.reached(0.0, 0.0)


@pytest.mark.system
def test_positions_and_modes_defined_again_act_in_the_moves_that_wait(arm: Arm) -> None:
    cell = Cell(arm)
    cell.define("elsewhere", 0.0, 0.05)
    arm.move(cell.at_part, cell.mode)
    second = arm.move(arm.position("next", arm.t6 @ cell.tool == cell.part), cell.mode)
    arm.sleep(0.2)
    arm.position("next", arm.t6 @ cell.tool == Expression("elsewhere"))
    arm.mode("slow", segment_time=0.9, acceleration_time=0.1)
    assert arm.plan(second).segment_time == pytest.approx(0.9)
    assert cell.reached(0.0, 0.05)


def test_a_redefinition_that_cannot_be_is_one_line_and_changes_nothing(arm: Arm) -> None:
    cell = Cell(arm)
    other = arm.position("other", arm.t6 @ cell.tool == cell.define("other", 0.0, 0.04))
    arm.move(cell.at_part, cell.mode)
    second = arm.move(other, cell.mode)
    arm.sleep(0.1)
    plan, waiting = arm.plan(second), arm.status.waiting
    reasons: dict[str, Callable[[], object]] = {
        "transform 'other' stays as it was": lambda: cell.define("other", 2.0, 0.0),
        "mode 'slow' stays as it was": lambda: arm.mode(
            "slow", segment_time=0.15, acceleration_time=0.1
        ),
    }
    for reason, redefine in reasons.items():
        with pytest.raises(MoveError, match=f"{reason}, .*move 2, to 'other' with 'slow'") as told:
            redefine()
        assert "\n" not in str(told.value)
    assert (arm.plan(second), arm.status.waiting) == (plan, waiting)
    assert cell.reached(0.0, 0.04)


# --- M11: names for ever -----------------------------------------------------------------------


@pytest.mark.system
def test_a_program_that_names_each_pick_removes_what_it_has_used(arm: Arm) -> None:
    cell = Cell(arm)
    for number in range(12):
        place = cell.define(f"pick {number}", 0.0, 0.01 * (number % 3))
        at = arm.position(f"pick {number}", arm.t6 @ cell.tool == place)
        arm.wait(arm.move(at, cell.mode))
        arm.remove(at, "position")
        arm.remove(place)
    assert cell.reached(0.0, 0.02)
    with pytest.raises(ProgramError, match="position 'pick 3' is not defined; there are: at part"):
        arm.move("pick 3", cell.mode)


def test_what_is_used_is_not_removed(arm: Arm) -> None:
    cell = Cell(arm)
    arm.move(cell.at_part, cell.mode)
    arm.sleep(0.1)
    refused: list[tuple[Callable[[], None], type[ProgramError], str]] = [
        (lambda: arm.remove(cell.tool), TransformError, "'tool' is used by position 'at part': "),
        (lambda: arm.remove("at part"), ProgramError, "'at part': move 1 is to be made with it: w"),
        (lambda: arm.remove("slow"), ProgramError, "mode 'slow': move 1 is to be made with it"),
        (lambda: arm.remove("slw"), ProgramError, "'slw': no transform, position or mode has this"),
        (lambda: arm.remove("slow", "position"), EquationError, "'slow' is not defined; there are"),
        (lambda: arm.remove("at part", "mode"), ModeError, "'at part' is not defined; there are: "),
        (lambda: arm.remove(arm.t6), TransformError, "'t6' is the arm itself and cannot be"),
    ]
    for remove, error, reason in refused:
        with pytest.raises(error, match=reason) as told:
            remove()
        assert "\n" not in str(told.value)
    assert cell.reached(0.0, 0.02)


def test_a_reference_that_was_removed_may_become_a_value(arm: Arm) -> None:
    seen = arm.reference("seen", Transform.identity())
    with pytest.raises(TransformError, match="'seen' is of kind reference and stays so"):
        arm.transform("seen", Transform.identity())
    arm.remove(seen)
    arm.transform("seen", Transform.identity())
    with pytest.raises(TransformError, match="'seen' is not a reference of this program"):
        arm.observe(seen, Transform.identity())


# --- replies that do not come ------------------------------------------------------------------


@pytest.mark.parametrize("lost", ["lose", "lose_replies"])
def test_a_lost_reply_redefines_and_removes_once(socket: CoreSocket, lost: str) -> None:
    arm = Arm(linked(socket))
    cell = Cell(arm)
    other = arm.position("other", arm.t6 @ cell.tool == cell.define("other", 0.0, 0.04))
    arm.move(cell.at_part, cell.mode)
    second = arm.move(other, cell.mode)
    arm.sleep(0.1)
    before = arm.plan(second)
    setattr(socket, lost, 2)
    cell.define("other", 0.0, 0.0)
    planned = arm.plan(second)
    assert planned != before
    cell.define("other", 0.0, 0.0)  # said again, it changes nothing
    assert arm.plan(second) == planned
    spare = cell.define("spare", 0.0, 0.0)
    setattr(socket, lost, 2)
    arm.remove(spare)
    removals = [one for one in socket.requests if isinstance(one, RemoveRequest)]
    assert len(removals) == 1


# --- what is sent ------------------------------------------------------------------------------


def test_removals_are_sent_by_name_and_checked_first() -> None:
    link = FakeLink()
    arm = Arm(link)
    part = arm.transform("part", TOOL)
    arm.remove(part)
    arm.remove("there")
    arm.remove("slow", "mode")
    assert link.heard[1:] == [
        RemoveRequest("part", "transform"),
        RemoveRequest("there"),
        RemoveRequest("slow", "mode"),
    ]
    for name, what, reason in (
        (part @ part, None, "remove part @ part: give one transform, as returned by arm.transform"),
        (part, "mode", "remove part: give one transform, .* or the name of a position or mode"),
        ("", None, "remove '': name '': expected `str` of length >= 1"),
        (3, None, "remove 3: name 3: expected `str`, got `int`"),
        ("slow", "modes", "remove 'slow': what 'modes': invalid enum value 'modes'"),
    ):
        with pytest.raises(ProgramError, match=reason):
            arm.remove(name, what)  # type: ignore[arg-type]
    assert len(link.heard) == 4


class Replanning(FakeLink):
    """A server that has planned move 1 again at each definition of a transform."""

    def request(self, message: object) -> Answer:
        answer = super().request(message)  # type: ignore[arg-type]
        if isinstance(message, TransformMessage):
            return Answer(replanned=[PlannedMove(1, 0.7, 0.01), PlannedMove(99, 1.0)])
        return answer


def test_the_plan_of_a_move_that_was_planned_again_is_the_new_one() -> None:
    arm = Arm(Replanning())
    assert arm.move("there", "slow") == 1
    arm.transform("part", TOOL)
    assert arm.plan(1) == (1, 0.7, 0.01, None)
    with pytest.raises(ProgramError, match="plan of move 99"):
        arm.plan(99)
