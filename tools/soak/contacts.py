"""Tracking, compliance in the air and in contact, and the examples in scenes drawn by the seed."""

from random import Random
from typing import Any, Final

from example_run import example

from rfms_can.arm import Arm as ArmData
from rfms_can.compliance import ControlLaw
from rfms_can.coordinator import Arm, Transform, Weave
from rfms_can.rig.session import Program
from soak.motions import Drawn, attempt

LAWS: Final = (
    *(ControlLaw.WEIGHTED.value,) * 3,
    *(law.value for law in ControlLaw if law is not ControlLaw.WEIGHTED),
)
"""The usual one most often."""
DITHERS: Final = (0.0, 0.5, 0.9, 1.0)
WORDS: Final = ("fx fy", "fz", "rx ry", "fx fy rx ry", "fx fy fz", "rx ry rz", "fx fy fz rx ry rz")
"""Directions that comply in the air."""
FREE_EXAMPLES: Final = (
    *("weave", "figures", "palletising", "pick_and_place", "transfer", "camera"),
    *("conveyor",) * 2,
)


def _of(name: str, **constants: Any) -> Program:
    """The program of an example, some of its constants changed."""
    program: Program = example(name, **constants).program
    return program


def conveyor(draw: Random, _data: ArmData) -> Drawn:
    """Parts on belts of several speeds, seen by cameras of several rates, late and with noise."""
    noise = Random(draw.random())
    size = draw.choice((0.0, 2e-4, 5e-4))
    module = example(
        "conveyor",
        SPEED=draw.uniform(0.03, 0.13),
        LATE=draw.choice((0.01, 0.02, 0.04)),
        FRAME=draw.choice((0.012, 0.02, 0.04)),
        RIDE=draw.uniform(0.4, 2.0),
    )

    class Belt(module.Belt):  # type: ignore[misc, name-defined]
        def picture(self, time: float) -> Transform:
            x, y, z = (noise.gauss(0.0, size) for _ in range(3))
            seen: Transform = self.part(time) @ Transform.translation(x, y, z)
            return seen

    module.Belt = Belt  # type: ignore[attr-defined]
    program: Program = module.program
    return Drawn(program, {})


def tracking(draw: Random, data: ArmData) -> Drawn:
    """A place that moves to and fro by itself, fast; others on the way to it and from it."""
    reach = 0.05 * (data.a2 + data.d4)

    def program(arm: Arm) -> None:
        hand = arm.transform("hand", arm.pose @ Transform.rotation((0.0, 1.0, 0.0), 0.3))
        home = arm.joint_position("home", data.park)
        far = arm.mode("far", joint_speed=0.8, acceleration_time=0.3, lengthen=True)
        for number in range(draw.randint(5, 9)):
            x, y, z = (draw.uniform(-reach, reach) for _ in range(3))
            weave = arm.functional(f"w {number}", Weave((x, y, z), draw.uniform(0.2, 1.2), "t"))
            place = arm.position(f"moves {number}", arm.t6 == hand @ weave)
            mode = arm.mode(
                f"join {number}",
                segment_time=draw.uniform(0.7, 1.5),
                acceleration_time=draw.uniform(0.15, 0.3),
                interpolation=draw.choice(("joint", "cartesian")),
                lengthen=True,
            )
            if attempt(lambda place=place, mode=mode: arm.move(place, mode)):  # type: ignore[misc]
                arm.sleep(draw.uniform(0.5, 3.0))
                arm.feed(draw.choice((0.5, 1.0, 1.0)))
        arm.feed(1.0)
        arm.wait(arm.move(home, far))

    return Drawn(program, {})


def floating(draw: Random, data: ArmData) -> Drawn:
    """Complies in the air, in one direction to six, with dither.

    For a second or so each time: nothing holds the arm, and where a joint's friction is less than
    what is compensated of it, it drifts until the bound of COMPLY stops it, as it should.
    """
    lift = 0.1 * (data.a2 + data.d4)

    def program(arm: Arm) -> None:
        home = arm.joint_position("home", data.park)
        down = arm.transform("down", Transform.translation(0.0, 0.0, -lift) @ arm.pose)
        below = arm.position("below", arm.t6 == down)
        for number in range(draw.randint(7, 14)):
            words = draw.choice(WORDS)
            arm.comply(words, *(0.0 for _ in words.split()))
            mode = arm.mode(
                f"floats {number % 2}",
                segment_time=draw.uniform(0.5, 1.2),
                acceleration_time=draw.uniform(0.1, 0.25),
                interpolation=draw.choice(("joint", "cartesian")),
                lengthen=True,
            )
            arm.wait(arm.move(below, mode))
            arm.lock(words)
            arm.wait(arm.move(home, arm.mode("back", segment_time=1.0, acceleration_time=0.3)))

    return Drawn(program, _force(draw))


def _force(draw: Random) -> dict[str, Any]:
    return {"law": draw.choice(LAWS), "dither": draw.choice(DITHERS)}


def _contact(draw: Random, scene: str) -> dict[str, Any]:
    """Settings of a run in a scene: the thesis' friction, some runs without a sensor."""
    sensor = draw.choice(("good", "good", "none"))
    return {**_force(draw), "scene": scene, "sensor": sensor, "friction": "thesis"}


def guarded(draw: Random, _data: ArmData) -> Drawn:
    """Guarded moves down to a plate of uncertain height."""
    scene = f"surface:z_mm={draw.uniform(-15, 15):.2f},tilt_x_deg={draw.uniform(-5, 5):.2f}"
    program = _of("touch", SPEED=draw.uniform(0.005, 0.02), FORCE=draw.uniform(5.0, 40.0))
    return Drawn(program, _contact(draw, scene))


def surface(draw: Random, _data: ArmData) -> Drawn:
    """Follows a tilted or a round surface with a force."""
    tilted = f"surface:tilt_y_deg={draw.uniform(-12, 12):.2f},tilt_x_deg={draw.uniform(-8, 8):.2f}"
    scene = draw.choice((tilted, f"curved:radius_mm={draw.uniform(250, 900):.1f}"))
    speed, force = draw.uniform(0.02, 0.08), draw.uniform(10.0, 40.0)
    return Drawn(_of("follow_surface", SPEED=speed, FORCE=force), _contact(draw, scene))


def peg(draw: Random, _data: ArmData) -> Drawn:
    """A peg into a hole that lies elsewhere and leans."""
    where = ",".join(f"{axis}_mm={draw.uniform(-1, 1):.3f}" for axis in "xy")
    leans = ",".join(f"tilt_{axis}_deg={draw.uniform(-0.5, 0.5):.3f}" for axis in "xy")
    scene = f"peg:{where},{leans},clearance_mm={draw.choice((0.1, 0.2, 0.5))}"
    return Drawn(_of(draw.choice(("peg_in_hole", "task_level"))), _contact(draw, scene))


def edges(draw: Random, _data: ArmData) -> Drawn:
    """A block along one wall and then another: what complies is exchanged in contact."""
    scene = f"corner:turn_deg={draw.uniform(-3, 3):.2f},y_mm={draw.uniform(-3, 3):.2f}"
    return Drawn(_of("trace_corner"), _contact(draw, scene) | {"sensor": "good"})


def examples(draw: Random, data: ArmData) -> Drawn:
    """An example that needs no scene."""
    names = FREE_EXAMPLES + ("thesis_peg",) * (data.name == "puma560")
    name = draw.choice(names)
    return Drawn(_of(name), {"friction": draw.choice(("corke", "thesis"))})
