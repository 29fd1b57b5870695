"""Programs that go by way of singular poses, and references that lead where the arm cannot go."""

from collections.abc import Callable
from math import cos, radians, sin

import numpy as np
import pytest
from random_programs.on_bus import Commanded

from rfms_can.arm import arm_by_name
from rfms_can.coordinator import Arm, Outcome, TrackingError, Transform
from rfms_can.kinematics import configuration_of, direct
from rfms_can.rig.runner import execute
from rfms_can.rig.settings import RunSettings

pytestmark = pytest.mark.system

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
turned = Transform.rotation
Program = Callable[[Arm], None]


def judged(program: Program, arm: str = "puma260", friction: str = "none") -> Commanded:
    """Run a program to its end without a fault, its commanded joints within their limits."""
    settings = RunSettings(arm=arm, friction=friction)
    commanded = Commanded(arm_by_name(arm), 1.0 / settings.rate)
    outcome = execute(program, settings, watch=commanded.watch)
    assert outcome.fault is None
    judge = commanded.judge
    assert judge is not None
    assert judge.acceleration <= 1.02
    assert judge.speed <= 1.05 + 1e-5
    return commanded


def go(arm: Arm, name: str, pose: Transform, mode: str) -> None:
    """One move, to its end."""
    number = arm.move(arm.position(name, arm.t6 == arm.transform(f"at {name}", pose)), mode)
    arm.wait(number)
    assert arm.outcome(number).how is Outcome.MADE


@pytest.mark.parametrize("first", [(40, -40, -40), (100, 30, -90), (-170, 25, 160)])
@pytest.mark.parametrize("then", [(-60, -30, 20), (140, 40, 10)])
def test_joint_moves_by_way_of_a_straight_wrist_are_made(
    first: tuple[int, int, int], then: tuple[int, int, int]
) -> None:
    """Accepted, and then halted by joint 4: it held the theta4 of the pose after the next."""
    ready = Transform.translation(0.2032, -0.12623, 0.2032) @ turned(Y, radians(90))

    def hand(a: float, b: float, c: float) -> Transform:
        wrist = turned(Z, radians(a)) @ turned(Y, radians(-b)) @ turned(Z, radians(c))
        return ready @ wrist

    def program(arm: Arm) -> None:
        arm.mode("m", segment_time=1.5, acceleration_time=0.3, lengthen=True)
        for name, pose in (("a", hand(*first)), ("ready", ready), ("b", hand(*then))):
            go(arm, name, pose, "m")

    judged(program)


def test_a_line_out_of_a_straight_wrist_is_made() -> None:
    """Its refusals once advised times that halted the arm at 87 rad/s."""
    a, b = radians(80), radians(100)
    place = (0.2032 * (cos(a) + sin(b)), -0.12623, 0.2032 * (sin(a) + cos(b)))
    ready = Transform.translation(*place) @ turned(Y, b)
    beside = turned(Z, radians(2)) @ turned(Y, radians(20)) @ turned(Z, radians(-2))

    def program(arm: Arm) -> None:
        arm.mode("j", segment_time=1.5, acceleration_time=0.3)
        arm.mode("l", segment_time=4.0, acceleration_time=0.3, interpolation="cartesian")
        go(arm, "from", ready @ beside, "j")
        go(arm, "ready", ready, "j")
        go(arm, "out", ready @ Transform.translation(0.0, 0.0, -0.03), "l")

    judged(program)


@pytest.mark.parametrize("arm", ["puma260", "puma560"])
@pytest.mark.parametrize("theta5", [0.0, 1e-4, -0.02])
def test_complying_at_a_straight_wrist_does_not_jump(arm: str, theta5: float) -> None:
    model = arm_by_name(arm)
    q1, q2, q3, q4, _, q6 = model.park
    straight = (q1, q2, q3, q4, theta5, q6)
    down = tuple(np.subtract(straight, (0.05, 0.02, 0.0, 0.0, 0.0, 0.0)).tolist())

    def program(hand: Arm) -> None:
        hand.mode("m", joint_speed=0.4, acceleration_time=0.3, lengthen=True)
        for name, q in (("there", straight), ("on", down)):
            a, b, c, d, e, f = q
            pose = direct(model, (a, b, c, d, e, f))
            config = str(configuration_of(model, (a, b, c, d, e, f)))
            hand.position(name, hand.t6 == hand.transform(f"at {name}", pose), config=config)
        hand.wait(hand.move("there", "m"))
        hand.comply("fx fy rx ry", 0.0, 0.0, 0.0, 0.0)
        hand.wait(hand.move("on", "m"))
        hand.sleep(0.5)

    judged(program, arm, "thesis")


def test_servoing_into_a_singularity_and_out_of_reach_is_heard_and_led_out_of() -> None:
    """One session goes on: the exception is caught, the next move starts where the arm stands."""
    heard: list[str] = []

    def program(arm: Arm) -> None:
        start = arm.pose
        part = arm.reference("part", start)
        arm.position("part", arm.t6 == part)
        arm.mode("follow", interpolation="cartesian", segment_time=1.0, acceleration_time=0.2)
        arm.mode("back", segment_time=2.0, acceleration_time=0.4, lengthen=True)
        arm.wait(arm.move("part", "follow"))
        for axis, way in ((X, 0.0), (Y, 0.01)):  # out of reach; then the wrist through zero
            try:
                for k in range(200):
                    shift = Transform.translation(0.0, 0.0, 0.0 if way else 0.01 * k)
                    arm.observe("part", start @ shift @ turned(axis, way * k))
                    arm.sleep(0.02)
            except TrackingError as error:
                heard.append(str(error))
                arm.wait()  # until it rests
            for _ in range(4):
                arm.observe("part", start)
                arm.sleep(0.02)
            arm.wait(arm.move("part", "back"))

    judged(program)
    assert heard
    assert all("reference 'part' leads there, observed at (" in line for line in heard)


def test_a_move_to_an_observation_out_of_reach_is_an_outcome() -> None:
    def program(arm: Arm) -> None:
        start = arm.pose
        arm.position("part", arm.t6 == arm.reference("part", start))
        arm.mode("follow", interpolation="cartesian", segment_time=2.0, acceleration_time=0.3)
        number = arm.move("part", "follow")
        arm.sleep(0.5)
        arm.observe("part", start @ Transform.translation(0.0, 0.0, 1.5))
        with pytest.raises(TrackingError, match=r"stopped short.*reference 'part'"):
            arm.wait(number)
        assert arm.outcome(number).how is Outcome.SHORT
        arm.observe("part", start)
        arm.wait(arm.move("part", "follow"))

    judged(program)
