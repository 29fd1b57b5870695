"""What the arm meets: as stiff and as slippery as stated, held while it slides, and read true."""

import math

import numpy as np
import pytest
from pytest import approx
from support.scene import SceneBench

from rfms_can.arm import PUMA_560
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.plant.scene import STEEL
from rfms_can.plant.scene.catalogue import SCENES
from rfms_can.plant.scene.corner import CORNER
from rfms_can.plant.scene.curved import CROWN
from rfms_can.plant.scene.peg_in_hole import HOLE
from rfms_can.plant.scene.surface import SURFACE
from rfms_can.transform import Transform

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)
X, Y, Z = 0, 1, 2
frictions = pytest.mark.parametrize("friction", ["none", "thesis"])


def at(place: Transform, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Transform:
    """A tip that looks down, at an offset from a place, m."""
    return place @ Transform.translation(x, y, z) @ DOWN


def along(axis: int, newton: float) -> list[float]:
    """A force along an axis of the tip."""
    force = [0.0] * 6
    force[axis] = newton
    return force


PRESSED = [
    pytest.param("surface", at(SURFACE), Z, 1, id="ball on a plate"),
    pytest.param("curved", at(CROWN), Z, 1, id="ball on a back"),
    pytest.param("corner", at(CORNER, x=-0.1, y=-0.020), Y, 4, id="face on a wall"),
    # the tip looks down: its x is the wall's -x
    pytest.param("corner", at(CORNER, x=-0.020, y=-0.1), X, 4, id="face on the other wall"),
]


def test_something_is_pressed_on_in_every_scene() -> None:
    pressed = {str(case.values[0]) for case in PRESSED}
    assert pressed == set(SCENES) - {"free", "peg"}, "the peg's own test: test_plant_scene.py"


@pytest.mark.parametrize(("scene", "tip", "axis", "points"), PRESSED)
def test_every_point_of_contact_is_as_stiff_as_stated(
    scene: str, tip: Transform, axis: int, points: int
) -> None:
    """In N/m at the tip, measured between two loads, friction of the arm left out."""
    sign = -1.0 if axis == X else 1.0
    bench = SceneBench(f"{scene}:friction=0")
    bench.put(tip)
    found = []
    for load in (20.0, 60.0):
        bench.control(tip, 0.3, comply=[axis], force=along(axis, sign * load))
        contact = bench.model.contact_force()
        assert contact.points == points
        assert contact.force[axis] == approx(-sign * load, rel=0.02)
        found.append((load, contact.depth))
    (load, depth), (more, deeper) = found
    assert (more - load) / (deeper - depth) == approx(points * STEEL.stiffness, rel=0.03)


def test_no_force_of_a_task_sinks_in_by_a_tenth_of_the_pegs_clearance() -> None:
    assert 100.0 / STEEL.stiffness <= 0.2e-3 / 10.0


@frictions
@pytest.mark.parametrize(
    "scene", ["surface", "surface:tilt_y_deg=8", "surface:tilt_x_deg=-8", "curved"]
)
def test_a_pressed_ball_slides_without_leaving_and_rubs_as_stated(
    scene: str, friction: str
) -> None:
    bench = SceneBench(scene, friction)
    bench.put(at(SURFACE, z=2e-4))
    bench.control(at(SURFACE), 0.2, comply=[Z], force=along(Z, 20.0))
    normal, rubs, points = [], [], []

    def look() -> None:
        contact, place = bench.model.contact_force(), bench.scene.place
        outwards = place.inverse() @ bench.tip
        height = outwards.px if scene == "curved" else 0.0
        # The normal at the ball's middle, seen from the place, then from the tip.
        n = np.array([height / 0.4, 0.0, math.sqrt(1.0 - (height / 0.4) ** 2)])
        n = np.array(outwards.rows())[:, :3].T @ n
        force = np.array(contact.force)
        pushed = force @ n
        points.append(contact.points)
        normal.append(pushed)
        rubs.append(np.linalg.norm(force - pushed * n) / pushed)

    for k in range(1, 401):  # 30 mm in 0.4 s, smoothly
        part = (k / 400) ** 3 * (10.0 - 15.0 * k / 400 + 6.0 * (k / 400) ** 2)
        bench.control(
            at(SURFACE, x=-0.03 * part), 1e-3, comply=[Z], force=along(Z, 20.0), each=look
        )
    assert set(points) == {1}
    assert min(normal) > 3.0
    assert max(rubs) < 0.2 * 1.02
    assert np.mean(rubs[100:300]) == approx(0.2, rel=0.02)


def test_a_ball_that_sticks_creeps_by_less_than_a_micrometre_a_second_and_newton() -> None:
    bench = SceneBench("surface")
    bench.put(at(SURFACE))
    pushed = [3.0, 0.0, 30.0, 0.0, 0.0, 0.0]  # within the cone
    bench.control(at(SURFACE), 0.4, comply=[X, Z], force=pushed)
    began = bench.tip.px
    bench.control(at(SURFACE), 0.4, comply=[X, Z], force=pushed)
    assert abs(bench.tip.px - began) / 0.4 / 3.0 < 1e-6


@frictions
def test_the_block_goes_along_one_wall_to_the_other_and_along_that(friction: str) -> None:
    """As Fig. 5.1 has it: y and turns about x and z are the wall's, then x and about y and z."""
    bench = SceneBench("corner:turn_deg=1", friction)
    first = {"comply": [Y, 3, 5], "force": along(Y, 20.0)}
    then = {"comply": [X, 4, 5], "force": along(X, -20.0)}
    bench.put(at(CORNER, x=-0.06, y=-0.024))
    bench.control(at(CORNER, x=-0.06, y=-0.024), 0.4, **first)  # type: ignore[arg-type]
    touched = []
    for k in range(301):
        goal = at(CORNER, x=-0.06 + 0.045 * k / 300, y=-0.020)
        bench.control(goal, 1e-3, **first)  # type: ignore[arg-type]
        touched.append(bench.model.contacts)
    assert min(touched) >= 1
    seen = bench.scene.place.inverse() @ bench.tip
    # The arm's friction leaves it turned by a degree about two axes, and each is 0.35 mm.
    assert (seen.px, seen.py) == approx((-0.020, -0.020), abs=9e-4)
    for k in range(301):
        goal = at(CORNER, x=-0.020, y=-0.020 - 0.04 * k / 300)
        bench.control(goal, 1e-3, **then)  # type: ignore[arg-type]
    bench.control(goal, 0.2, **then)  # type: ignore[arg-type]
    seen = bench.scene.place.inverse() @ bench.tip
    assert seen.px == approx(-0.020, abs=1.5e-4)
    assert seen.py == approx(-0.060, abs=1e-3)
    assert bench.model.contact_force().force[X] == approx(20.0, rel=0.25)


@frictions
@pytest.mark.parametrize(("scene", "tip", "axis", "points"), PRESSED)
def test_what_the_sensor_feels_less_the_tools_weight_is_the_contact_force(
    scene: str, tip: Transform, axis: int, points: int, friction: str
) -> None:
    bench = SceneBench(scene, friction)
    bench.put(tip)
    load = -30.0 if axis == X else 30.0
    bench.control(tip, 0.4, comply=[axis], force=along(axis, load))
    felt = np.array(bench.model.wrist_force()) - bench.weight()
    contact = bench.model.contact_force()
    assert felt[:3] == approx(-np.array(contact.force), abs=0.05)
    lever = (0.0, 0.0, bench.tool.tip.pz)
    torque = -np.array(contact.torque) - np.cross(lever, contact.force)
    assert felt[3:] == approx(torque, abs=0.02)


@pytest.mark.parametrize("load", [30.0, 60.0])
def test_an_arm_that_sticks_rests_on_a_contact_and_nothing_moves(load: float) -> None:
    """Exact stiction of six joints on a stiff contact, the drives giving no more than gravity."""
    bench = SceneBench("surface", "thesis")
    bench.put(at(SURFACE, z=5e-5))
    bench.control(at(SURFACE), 0.3, comply=[Z], force=along(Z, load))
    torque = bench.holding()
    for _ in range(200):
        bench.model.step(torque, steps=4)
    at_rest, q = bench.model.contact_force(), bench.model.q[:]
    assert at_rest.force[2] < -1.0
    for _ in range(500):
        bench.model.step(torque, steps=4)
        assert bench.model.qd == [0.0] * 6
    assert bench.model.q == q
    later = bench.model.contact_force()
    assert later.force[2] == approx(at_rest.force[2], rel=1e-3)
    # sideways, joints and contact share what holds the ball as their friction lets them
    assert math.hypot(*later.force[:2]) < 0.2 * abs(later.force[2]) * 1.001


def test_a_dropped_arm_gains_no_energy_from_what_it_falls_on() -> None:
    bench = SceneBench("surface")
    bench.put(at(SURFACE, z=0.01))
    weightless = bench.holding()
    bench.model.step([0.9 * t for t in weightless], steps=4)
    energy = [bench.energy()]
    peak = 0
    for _ in range(400):
        before, worked = np.array(bench.model.q), bench.energy()
        bench.model.step([0.9 * t for t in weightless], steps=4)
        moved = np.array(bench.model.q) - before
        energy.append(bench.energy() - worked - 0.9 * float(np.dot(weightless, moved)))
        peak = max(peak, bench.model.contacts)
    assert peak == 1
    assert max(energy[1:]) < 2e-3  # J in a millisecond; the arm carries 10 J


def test_forces_are_means_of_the_period_that_was_stepped() -> None:
    """A ball falls on a plate: the same steps, once at a time, and once sixteen at a time."""
    one, sixteen = SceneBench("surface"), SceneBench("surface")
    for bench in (one, sixteen):
        bench.put(at(SURFACE, z=2e-4))
    torque = [0.9 * t for t in one.holding()]
    knocked = 0
    for _ in range(12):
        wrist, pushed, turned, points = np.zeros(6), np.zeros(3), np.zeros(3), []
        for _ in range(16):
            one.model.step(torque)
            contact = one.model.contact_force()
            wrist += one.model.wrist_force()
            pushed += contact.force
            turned += contact.torque
            points.append(contact.points)
        sixteen.model.step(torque, steps=16)
        contact = sixteen.model.contact_force()
        assert sixteen.model.q == one.model.q
        assert sixteen.model.wrist_force() == approx(list(wrist / 16), rel=1e-9, abs=1e-9)
        assert contact.force == approx(list(pushed / 16), rel=1e-3, abs=1e-3)
        assert contact.torque == approx(list(turned / 16), rel=1e-3, abs=1e-3)
        assert contact.points == max(points)
        knocked += 0 < sum(points) < 16
    assert knocked > 0  # periods with a blow in them


def test_the_sensor_feels_the_tools_inertia() -> None:
    """A joint turned alone by a torque: the peg's mass times what its middle is accelerated."""
    bench = SceneBench("surface")
    bench.put(at(SURFACE, z=0.1))
    torque = bench.holding()
    torque[0] += 20.0
    bench.model.step(torque, steps=4)
    moved = np.array(bench.model.qd) / 1e-3
    dynamics = ArmDynamics(PUMA_560)
    dynamics.update(bench.model.q)
    acceleration = dynamics.J @ moved
    com = np.array(bench.tool.com)
    linear = acceleration[:3] + np.cross(acceleration[3:], com)
    felt = np.array(bench.model.wrist_force())[:3] - bench.weight()[:3]
    assert np.linalg.norm(felt) > 0.5
    assert felt == approx(bench.tool.mass * linear, abs=0.01)


def test_a_hole_off_its_place_is_where_the_keys_say() -> None:
    from rfms_can.plant.scene.catalogue import scene_from

    keys = "peg:x_mm=0.7,y_mm=-0.3,tilt_x_deg=0.4,tilt_y_deg=-0.2"
    off = HOLE.inverse() @ scene_from(keys, "puma560").place
    assert (off.px, off.py, off.pz) == approx((0.7e-3, -0.3e-3, 0.0))
    assert math.degrees(off.oz) == approx(0.4, rel=1e-3)
    assert math.degrees(off.ax) == approx(-0.2, rel=1e-3)
