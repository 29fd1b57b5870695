"""Fast motion: strokes at the limits, corners, payloads, excitations, random programs."""

from collections.abc import Callable, Sequence
from random import Random
from typing import Any, Final, NamedTuple

from random_programs.on_bus import Batch

from rfms_can.arm import Arm as ArmData
from rfms_can.arm import known_load
from rfms_can.coordinator import Arm, Transform
from rfms_can.errors import ProgramError
from rfms_can.identification.compensation_comparison import uncompensated
from rfms_can.identification.experiments.actions import program_of
from rfms_can.identification.experiments.plan import experiments
from rfms_can.rig.session import Program
from rfms_can.rig.settings import RunSettings

RANDOM_SEEDS: Final = 20_000
"""Random programs that the campaign of docs/random-programs.md has run."""
IN_A_RUN: Final = 3
ELBOW_DOWN: Final = -1.0
"""Centre of joint 5, rad: clear of the wrist's singularity and of the end of its range."""
ENDURANCE_S: Final = 130.0
NAMES: Final = 8
"""That strokes define, again and again."""
CLEARANCE_RAD: Final = 0.1
"""Of strokes from the ends of the ranges."""


class Drawn(NamedTuple):
    """A program that was drawn.

    Attributes:
        program: to run.
        settings: of the run besides arm and plant, by the names of ``RunSettings``.
        load: whether the known load is in the hand.
        starts: how often it is run, each from power-up.
    """

    program: Program
    settings: dict[str, Any]
    load: bool = False
    starts: int = 1


Make = Callable[[Random, ArmData], Drawn]


def attempt(ask: Callable[[], object]) -> bool:
    """Ask for something; whether it was not refused."""
    try:
        ask()
    except ProgramError:
        return False
    return True


def random_programs(draw: Random, data: ArmData) -> Drawn:
    """Programs of the campaign of random programs, one after the other."""
    seeds = [draw.randrange(RANDOM_SEEDS) for _ in range(IN_A_RUN)]
    return Drawn(Batch(data.name, seeds).program, {})


def _end(draw: Random, data: ArmData, half_s: float) -> list[float]:
    """An end of strokes: each joint so far from its centre that all run at their limits."""
    centre = list(data.park)
    centre[4] = ELBOW_DOWN
    found = []
    for middle, speed, limits in zip(centre, data.speed_limits, data.joint_limits, strict=True):
        lower, upper = limits[0] + CLEARANCE_RAD, limits[1] - CLEARANCE_RAD
        angle = middle + draw.choice((-1.0, 1.0)) * draw.uniform(0.8, 1.0) * half_s * speed
        found.append(min(max(angle, lower), upper))
    return found


def _stroke_mode(draw: Random, name: str, arm: Arm, **load: Any) -> str:
    return arm.mode(
        name,
        joint_speed=draw.choice((1.0, 1.0, draw.uniform(0.5, 1.0))),
        acceleration_time=draw.uniform(0.06, 0.3),
        lengthen=True,
        **load,
    )


def _pause(draw: Random, arm: Arm) -> None:
    arm.pause()
    arm.sleep(draw.uniform(0.1, 0.5))
    arm.resume()


def _feed(draw: Random, arm: Arm) -> None:
    for _ in range(draw.randint(1, 3)):
        arm.feed(draw.choice((0.2, 0.5, 0.8, 1.0)))
        arm.sleep(draw.uniform(0.02, 0.3))
    arm.feed(1.0)


def _stop(draw: Random, arm: Arm) -> None:
    arm.stop()
    arm.sleep(draw.uniform(0.0, 0.3))


def _rest(draw: Random, arm: Arm) -> None:
    attempt(arm.wait)
    arm.sleep(draw.uniform(0.0, 1.0))


def _go_on(draw: Random, arm: Arm) -> None:
    arm.sleep(draw.uniform(0.0, 0.2))


INTERRUPTIONS: Final = (_go_on, _go_on, _go_on, _pause, _feed, _stop, _rest)
"""What happens during a stroke."""


def strokes(draw: Random, data: ArmData) -> Drawn:
    """All joints to and fro at their speed limits: reversals, pauses, stops, changes of feed."""

    def program(arm: Arm) -> None:
        _strokes(draw, data, arm, draw.randint(20, 40))

    return Drawn(program, {})


def endurance(draw: Random, data: ArmData) -> Drawn:
    """Strokes for two minutes and more, from one power-up: what grows with cycles shows."""

    def program(arm: Arm) -> None:
        while arm.time < ENDURANCE_S:
            _strokes(draw, data, arm, 20)

    return Drawn(program, {})


def _strokes(draw: Random, data: ArmData, arm: Arm, count: int, **load: Any) -> None:
    half_s = draw.uniform(0.1, 0.5)
    for number in range(count):
        name = f"stroke {number % NAMES}"
        place = arm.joint_position(name, _end(draw, data, half_s))
        mode = _stroke_mode(draw, name, arm, **load)
        if attempt(lambda place=place, mode=mode: arm.move(place, mode)):  # type: ignore[misc]
            arm.sleep(draw.uniform(0.0, 1.2))
            draw.choice(INTERRUPTIONS)(draw, arm)
    attempt(arm.wait)


def payload(draw: Random, data: ArmData) -> Drawn:
    """Strokes with the known load in the hand, which the modes tell of; grips in between."""
    load = known_load(data)
    told = {"mass": load.mass, "mass_centre": load.com}

    def program(arm: Arm) -> None:
        for _ in range(draw.randint(2, 4)):
            _strokes(draw, data, arm, draw.randint(4, 9), **told)
            draw.choice((arm.gripper.close, arm.gripper.open))()

    return Drawn(program, {}, load=True)


def corners(draw: Random, data: ArmData) -> Drawn:
    """Straight lines about where the hand is, corner by corner; some turn the hand."""
    size = 0.25 * (data.a2 + data.d4)

    def program(arm: Arm) -> None:
        down = arm.joint_position("begin", _middle(data))
        arm.wait(arm.move(down, arm.mode("far", joint_speed=0.8, acceleration_time=0.3)))
        middle = arm.pose
        for number in range(draw.randint(15, 30)):
            _corner(draw, arm, number, middle, size)
        attempt(arm.wait)

    return Drawn(program, {})


def _corner(draw: Random, arm: Arm, number: int, middle: Transform, size: float) -> None:
    along: Sequence[float] = [draw.uniform(-size, size) for _ in range(3)]
    axis = draw.choice(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    turn = Transform.rotation(axis, draw.choice((0.0, draw.uniform(-0.4, 0.4))))
    x, y, z = along
    there = arm.transform(f"corner {number}", Transform.translation(x, y, z) @ middle @ turn)
    position = arm.position(f"at {number}", arm.t6 == there)
    mode = arm.mode(
        f"line {number}",
        speed=draw.uniform(0.1, 0.6),
        acceleration_time=draw.uniform(0.08, 0.25),
        interpolation="cartesian",
        transition=draw.choice(("joint", "cartesian")),
        lengthen=True,
    )
    if attempt(lambda: arm.move(position, mode)):
        arm.sleep(draw.uniform(0.0, 0.7))
        if draw.random() < 0.3:
            draw.choice(INTERRUPTIONS)(draw, arm)


def _middle(data: ArmData) -> list[float]:
    """The park pose with the wrist away from its singularity, rad (6)."""
    angles = list(data.park)
    angles[2] += 0.4
    angles[4] = ELBOW_DOWN
    return angles


def excitation(draw: Random, data: ArmData) -> Drawn:
    """An experiment of ``rfms identify``; the master compensates no dynamics in these."""
    experiment = draw.choice(experiments(data))
    program = program_of(experiment.actions, data, [])
    settings = uncompensated(RunSettings(arm=data.name))
    given = {name: getattr(settings, name) for name in ("dynamics", "law", "following_error")}
    return Drawn(program, given, load=experiment.load)


def restarts(draw: Random, data: ArmData) -> Drawn:
    """Power-up, homing, a few strokes, off: again and again."""

    def program(arm: Arm) -> None:
        _strokes(draw, data, arm, draw.randint(1, 4))

    return Drawn(program, {}, starts=draw.randint(4, 7))
