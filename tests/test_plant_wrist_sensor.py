"""The wrist sensor: what it makes of the truth, and its frame."""

import statistics

import pytest
from support.bench import PERIOD_NS, Bench

from rfms_can.arm import PUMA_560
from rfms_can.errors import PlantError
from rfms_can.kinematics import direct
from rfms_can.plant.node import PlantNode
from rfms_can.plant.physics import PlantPhysics
from rfms_can.plant.scene.peg_in_hole import PegInHole
from rfms_can.plant.wrist_sensor import GOOD, IDEAL, WristSensor, sensor_from
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Force

TRUTH = (10.0, -20.0, 30.0, 0.5, -0.25, 0.1)


def test_a_perfect_sensor_reads_the_truth() -> None:
    assert WristSensor(IDEAL).sample(TRUTH) == pytest.approx(TRUTH)


def test_bias_scale_and_noise_are_those_stated() -> None:
    sensor = WristSensor(GOOD)
    samples = [sensor.sample(TRUTH) for _ in range(4000)]
    for channel, values in enumerate(zip(*samples, strict=True)):
        mean = GOOD.scale[channel] * TRUTH[channel] + GOOD.bias[channel]
        sigma = GOOD.noise[channel]
        assert statistics.mean(values) == pytest.approx(mean, abs=4.0 * sigma / 4000**0.5)
        assert statistics.stdev(values) == pytest.approx(sigma, rel=0.05)


def test_the_noise_is_that_of_its_seed() -> None:
    one, same, other = (WristSensor(GOOD, seed) for seed in (4, 4, 5))
    noise = [one.sample(TRUTH) for _ in range(3)]
    assert noise == [same.sample(TRUTH) for _ in range(3)]
    assert noise != [other.sample(TRUTH) for _ in range(3)]


def test_a_sensor_is_asked_for_by_name() -> None:
    assert sensor_from("none", 1) is None
    ideal = sensor_from("ideal", 1)
    assert ideal is not None and ideal.sample(TRUTH) == pytest.approx(TRUTH)
    with pytest.raises(PlantError, match="'best' does not exist; there are: none, ideal, good"):
        sensor_from("best", 1)


def test_beyond_its_range_it_saturates() -> None:
    reading = WristSensor(IDEAL).sample((1e4, -1e4, 0.0, 1e3, -1e3, 0.0))
    assert reading == [400.0, -400.0, 0.0, 40.0, -40.0, 0.0]


@pytest.mark.parametrize("sensor", [WristSensor(IDEAL), None])
def test_the_plant_sends_force_only_with_a_sensor(wire: Wire, sensor: WristSensor | None) -> None:
    scene = PegInHole().scene(Transform.translation(0.55, 0.2, -0.6))
    physics = PlantPhysics(PUMA_560, "none", 250.0, scene=scene, sensor=sensor)
    bench = Bench(PlantNode(physics, wire, 0x109, PERIOD_NS), wire)
    for _ in range(3):
        bench.sync()
    force = [heard for heard in bench.heard if isinstance(heard.values, Force)]
    if sensor is None:
        assert not force
        return
    assert [heard.values.cycle for heard in force] == [0, 1, 2]
    # Braked at rest: the weight of the peg, along the base's -z, as T6 sees it.
    tool, pose = PegInHole().tool(), direct(PUMA_560, physics.true_q)
    weight = 9.81 * tool.mass
    expected = [weight * pose.nz, weight * pose.oz, weight * pose.az]
    assert list(force[-1].values[:3]) == pytest.approx(expected, abs=0.05)
