"""True parameters of the plant: those of the data sheet, or perturbed ones, to be identified.

``nominal``          the arm's own numbers and ideal boards
``table41``          drives after Table 4.1 of the thesis, boards with noise
``perturbed:SEED``   masses +-30 %, friction +-50 %, torque +-10 %, one amplifier with a current
                     offset, one encoder that counts backwards; drawn by the seed
``rewired:SEED``     the same with that encoder corrected
``worn:SEED``        sound, but not as the servos have it: friction 0.9 to 1.5 of the set, each
                     joint its own; tachometers, converters and their noise drawn by the seed

Each with ``+load``: the known load (``arm/load.py``) hangs in the hand.
"""

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from rfms_can.arm import JOINT_COUNT, Arm, JointFriction, Link, Load, friction_set, known_load
from rfms_can.arm.load import NOTHING
from rfms_can.arm.torque_law import TorqueLaw, driven_by, table_4_1
from rfms_can.errors import PlantError
from rfms_can.plant.board import Board
from rfms_can.plant.imperfect_board import IDEAL, BoardErrors, ImperfectBoard

MASSES: Final = 0.3
FRICTION: Final = 0.5
TORQUE: Final = 0.1
LOAD_DEPENDENCE: Final = 0.03
"""Relative ranges of ``perturbed``; the last is friction over the motor's torque."""
CURRENT_OFFSET: Final = (30, 60)
"""Smallest and largest current offset, codes."""
NOISY: Final = BoardErrors(
    adc_slope=0.92, adc_offset=-11.0, current_noise=2.0, velocity_noise=1.5
)  # P: the printed A_c and B_c overflow the converter (see Board)
WORN_FRICTION: Final = (0.9, 1.5)
"""Smallest and largest friction of ``worn`` over that of the set, drawn for each joint."""
WORN_SLOPE: Final = (0.92, 1.05)
WORN_OFFSET: Final = (-15.0, 15.0)
WORN_CURRENT_NOISE: Final = (0.0, 3.0)
WORN_VELOCITY_NOISE: Final = (0.0, 2.0)
WORN_TACHOMETER: Final = (0.97, 1.03)
"""Ranges of the boards of ``worn``: A_c, B_c (codes), standard deviations (codes), gain."""
SEPARATOR: Final = ":"
WITH_LOAD: Final = "+load"


@dataclass(frozen=True, slots=True, eq=False)
class Variant:
    """A plant: links, drives, friction, boards, load.

    Attributes:
        name: as asked for.
        arm: links and drives as they are.
        friction: one per joint.
        board_errors: one per board.
        load: in the hand.
        seed: of the boards' noise.
    """

    name: str
    arm: Arm
    friction: tuple[JointFriction, ...]
    board_errors: tuple[BoardErrors, ...] = (IDEAL,) * JOINT_COUNT
    load: Load = NOTHING
    seed: int = 0

    def boards(self, q: Sequence[float]) -> tuple[Board, ...]:
        """The six boards, powered up at ``q`` (6, rad)."""
        return tuple(self._board(joint, angle) for joint, angle in enumerate(q))

    def _board(self, joint: int, q: float) -> Board:
        board_errors = self.board_errors[joint]
        if board_errors == IDEAL:
            return Board(self.arm, joint, q)
        noise = random.Random(self.seed * JOINT_COUNT + joint)
        return ImperfectBoard(self.arm, joint, q, board_errors, noise)

    @property
    def laws(self) -> tuple[TorqueLaw, ...]:
        """The true torque laws of the joints, which identification is to find."""
        boards = [self.arm.board_scale(joint) for joint in range(JOINT_COUNT)]
        return tuple(
            TorqueLaw.of(abs(board.torque_per_dac_code), friction, self._offset(joint))
            for joint, (board, friction) in enumerate(zip(boards, self.friction, strict=True))
        )

    def _offset(self, joint: int) -> float:
        sign = 1.0 if self.arm.drives[joint].gear_ratio > 0.0 else -1.0
        return sign * self.board_errors[joint].current_offset

    @property
    def rigid(self) -> Arm:
        """The arm with the links of the physics engine, corrections applied."""
        links = tuple(
            Link(link.physical_mass, link.com, link.physical_inertia) for link in self.arm.links
        )
        return replace(self.arm, links=links)


def as_built(arm: Arm, friction: str) -> Variant:
    """The arm of the data sheet with one of its friction sets."""
    return Variant("nominal", arm, friction_set(arm, friction))


def make_variant(name: str, arm: Arm, friction: str) -> Variant:
    """The plant called ``name`` of an arm; ``friction`` names the friction set it starts from.

    Raises:
        PlantError: the name does not exist.
        ArmError: the friction set does not exist.
    """
    kind, loaded, rest = name.partition(WITH_LOAD)
    word, given, seed = kind.partition(SEPARATOR)
    make = _KINDS.get((word, bool(given)))
    if rest or make is None or (given and not (seed.isascii() and seed.isdecimal())):
        names = f"{', '.join(WORDS)}, each with {WITH_LOAD} or without"
        raise PlantError(f"no plant {name!r}; there are: {names}; SEED is a whole number")
    variant = make(as_built(arm, friction), int(seed or 0))
    return replace(variant, name=name, load=known_load(arm) if loaded else NOTHING)


def _nominal(variant: Variant, _: int) -> Variant:
    return variant


def _table41(variant: Variant, _: int) -> Variant:
    laws = table_4_1(variant.arm)
    friction = tuple(law.friction for law in laws)
    board_errors = (NOISY,) * JOINT_COUNT
    return replace(
        variant, arm=driven_by(variant.arm, laws), friction=friction, board_errors=board_errors
    )


def _rewired(variant: Variant, seed: int) -> Variant:
    draw = random.Random(seed)

    def about_one(fraction: float) -> float:
        return draw.uniform(1.0 - fraction, 1.0 + fraction)

    links = tuple(_heavier(link, about_one(MASSES)) for link in variant.arm.links)
    friction = tuple(
        JointFriction(
            joint.coulomb_positive * about_one(FRICTION),
            joint.coulomb_negative * about_one(FRICTION),
            joint.viscous * about_one(FRICTION),
            draw.uniform(0.0, LOAD_DEPENDENCE),
        )
        for joint in variant.friction
    )
    drives = tuple(
        replace(drive, torque_limit=drive.torque_limit * about_one(TORQUE))
        for drive in variant.arm.drives
    )
    biased = draw.randrange(JOINT_COUNT)
    offset = draw.choice((-1, 1)) * draw.randint(*CURRENT_OFFSET)
    board_errors = [NOISY] * JOINT_COUNT
    board_errors[biased] = replace(NOISY, current_offset=offset)
    arm = replace(variant.arm, links=links, drives=drives)
    return replace(variant, arm=arm, friction=friction, board_errors=tuple(board_errors), seed=seed)


def _perturbed(variant: Variant, seed: int) -> Variant:
    rewired = _rewired(variant, seed)
    board_errors = list(rewired.board_errors)
    straight = [joint for joint in range(JOINT_COUNT) if not board_errors[joint].current_offset]
    backwards = random.Random(~seed).choice(straight)
    board_errors[backwards] = replace(board_errors[backwards], encoder_sign=-1)
    return replace(rewired, board_errors=tuple(board_errors))


def _worn(variant: Variant, seed: int) -> Variant:
    draw = random.Random(seed)
    friction = tuple(joint.scaled(draw.uniform(*WORN_FRICTION)) for joint in variant.friction)
    board_errors = tuple(
        BoardErrors(
            adc_slope=draw.uniform(*WORN_SLOPE),
            adc_offset=draw.uniform(*WORN_OFFSET),
            current_noise=draw.uniform(*WORN_CURRENT_NOISE),
            velocity_noise=draw.uniform(*WORN_VELOCITY_NOISE),
            tachometer_gain=draw.uniform(*WORN_TACHOMETER),
        )
        for _ in range(JOINT_COUNT)
    )
    return replace(variant, friction=friction, board_errors=board_errors, seed=seed)


def _heavier(link: Link, factor: float) -> Link:
    """A link of another density: physical mass and inertia times ``factor``."""
    xx, yy, zz = (factor * inertia for inertia in link.physical_inertia)
    return Link(factor * link.physical_mass, link.com, (xx, yy, zz))


_KINDS: Final[dict[tuple[str, bool], Callable[[Variant, int], Variant]]] = {
    ("nominal", False): _nominal,
    ("table41", False): _table41,
    ("perturbed", True): _perturbed,
    ("rewired", True): _rewired,
    ("worn", True): _worn,
}
"""By name, and whether a seed follows."""

WORDS: Final = tuple(f"{word}{SEPARATOR}SEED" if seeded else word for word, seeded in _KINDS)
"""The plants that exist, as they are called."""
