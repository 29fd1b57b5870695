"""The probe: wires that go the wrong way are found with small torques, before any servo closes."""

import random
from dataclasses import replace

import pytest

from rfms_can.arm import ARMS, arm_by_name
from rfms_can.bus.simulated import SimulatedBus
from rfms_can.bus.timing import BusTiming
from rfms_can.identification.experiments.probe import FULL_SCALE, LEVELS, Finding, Probe
from rfms_can.identification.experiments.probing import WiringError, probe, require_sound
from rfms_can.plant.imperfect_board import ImperfectBoard
from rfms_can.plant.node import PlantNode
from rfms_can.plant.physics import PlantPhysics
from rfms_can.plant.variant import Variant, make_variant
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire

SETTINGS = RunSettings(arm="puma560")


def probed(variant: Variant, arm: str = "puma560") -> tuple[Probe, PlantPhysics]:
    wire, settings = Wire(), replace(SETTINGS, arm=arm)
    physics = PlantPhysics(arm_by_name(arm), "corke", 250.0, variant=variant)
    node = Probe(arm_by_name(arm), wire, 1, 4_000_000)
    bus = SimulatedBus(BusTiming())
    for each in (PlantNode(physics, wire, 2, settings.watch_ns), node):
        bus.attach(each)
    bus.run_until(lambda: node.done)
    return node, physics


@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize("plant", ["nominal", "table41", "nominal+load", "rewired:5"])
def test_an_arm_that_is_wired_right_passes(arm: str, plant: str) -> None:
    found = probe(replace(SETTINGS, arm=arm, plant=plant))
    require_sound(found)
    assert [finding.joint for finding in found.findings] == [1, 2, 3, 4, 5, 6]
    for finding in found.findings:
        ways = (finding.encoder, finding.tachometer, finding.coarse)
        assert min(ways) > 0.5 * max(ways)


@pytest.mark.parametrize("seed", range(8))
def test_an_encoder_that_counts_backwards_is_named_before_torque_grows(seed: int) -> None:
    settings = replace(SETTINGS, plant=f"perturbed:{seed}")
    variant = make_variant(settings.plant, settings.the_arm, settings.friction)
    (joint,) = [j for j, w in enumerate(variant.board_errors, start=1) if w.encoder_sign < 0]
    found = probe(settings)
    with pytest.raises(WiringError, match=f"^joint {joint}: its encoder counts backwards"):
        require_sound(found)
    assert found.largest_code <= LEVELS[-1] < 0.5 * FULL_SCALE
    assert found.largest_displacement < 0.03


def test_the_arm_stays_where_it_was() -> None:
    arm = arm_by_name("puma560")
    node, physics = probed(make_variant("perturbed:1", arm, "corke"))
    assert node.done
    moved = [abs(q - park) for q, park in zip(physics.true_q, arm.park, strict=True)]
    assert max(moved) < 0.1


def backwards(monkeypatch: pytest.MonkeyPatch, joint: int, what: str) -> Probe:
    """An arm with ideal boards, of which one is wired wrong otherwise."""
    arm = arm_by_name("puma560")
    variant = make_variant("table41", arm, "corke")
    original = ImperfectBoard.set_dacs
    drawn = ImperfectBoard.sample

    def torque(board: ImperfectBoard, current: int, force: int = 0) -> float:
        sign = -1.0 if what == "motor" and board is physics._boards[joint] else 1.0
        return sign * original(board, current, force)

    def sample(board: ImperfectBoard) -> tuple[int, int, int, bool]:
        counts, current, speed, seen = drawn(board)
        wrong = what == "tachometer" and board is physics._boards[joint]
        return counts, current, -speed if wrong else speed, seen

    monkeypatch.setattr(ImperfectBoard, "set_dacs", torque)
    monkeypatch.setattr(ImperfectBoard, "sample", sample)
    wire = Wire()
    physics = PlantPhysics(arm, "corke", 250.0, variant=variant)
    node = Probe(arm, wire, 1, 4_000_000)
    bus = SimulatedBus(BusTiming())
    for each in (PlantNode(physics, wire, 2, SETTINGS.watch_ns), node):
        bus.attach(each)
    bus.run_until(lambda: node.done)
    return node


@pytest.mark.parametrize(
    ("what", "told"),
    [
        ("motor", "joint 3: its motor turns backwards"),
        ("tachometer", "joint 3: its tachometer reads backwards"),
    ],
)
def test_other_wires_are_told_apart(monkeypatch: pytest.MonkeyPatch, what: str, told: str) -> None:
    with pytest.raises(WiringError, match=f"^{told}"):
        require_sound(backwards(monkeypatch, 2, what))


def test_a_joint_that_does_not_move_is_named() -> None:
    arm = arm_by_name("puma560")
    variant = make_variant("nominal", arm, "corke")
    stuck = list(variant.friction)
    stuck[3] = replace(stuck[3], coulomb_positive=50.0, coulomb_negative=50.0)
    node, _ = probed(replace(variant, friction=tuple(stuck)))
    with pytest.raises(WiringError, match=r"^joint 4 does not move at 49 % of its current"):
        require_sound(node)


def test_words_for_every_combination() -> None:
    draw = random.Random(1)
    for _ in range(200):
        ways = [draw.choice((-1.0, 0.0, 1.0)) * draw.uniform(0.5, 1.0) * 0.02 for _ in range(3)]
        problem = Finding(2, 500, *ways).problem
        assert (problem is None) == all(way > 0.0 for way in ways)
        assert problem is None or problem.startswith("joint 2")
