"""What the plant is really like: the arm of the data sheet, or one that nobody has measured yet.

``nominal``          the arm's own numbers and ideal boards
``table41``          drives after Table 4.1 of the thesis, boards with noise
``perturbed:SEED``   masses +-30 %, friction +-50 %, torque +-10 %, one amplifier with a current of
                     its own, one encoder that counts backwards; drawn by the seed
``rewired:SEED``     the same with that encoder put right

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
from rfms_can.plant.wired_board import IDEAL, WiredBoard, Wiring

MASSES: Final = 0.3
FRICTION: Final = 0.5
TORQUE: Final = 0.1
LOAD_DEPENDENCE: Final = 0.03
"""How far ``perturbed`` goes to either side; the last is friction over the motor's torque."""
CURRENT_OFFSET: Final = (30, 60)
"""Codes, least and most, of the amplifier with a current of its own."""
NOISY: Final = Wiring(
    adc_slope=0.92, adc_offset=-11.0, current_noise=2.0, velocity_noise=1.5
)  # P: the printed A_c and B_c overflow the converter (see Board)
SEPARATOR: Final = ":"
WITH_LOAD: Final = "+load"
NAMES: Final = "nominal, table41, perturbed:SEED, rewired:SEED, each with +load or without"


@dataclass(frozen=True, slots=True, eq=False)
class Variant:
    """A plant: links, drives, friction, boards, load.

    Attributes:
        name: as asked for.
        arm: links and drives as they are.
        friction: one per joint.
        wiring: one per board.
        load: in the hand.
        seed: of the boards' noise.
    """

    name: str
    arm: Arm
    friction: tuple[JointFriction, ...]
    wiring: tuple[Wiring, ...] = (IDEAL,) * JOINT_COUNT
    load: Load = NOTHING
    seed: int = 0

    def boards(self, q: Sequence[float]) -> tuple[Board, ...]:
        """The six boards, powered up at ``q`` (6, rad)."""
        return tuple(self._board(joint, angle) for joint, angle in enumerate(q))

    def _board(self, joint: int, q: float) -> Board:
        wiring = self.wiring[joint]
        if wiring == IDEAL:
            return Board(self.arm, joint, q)
        noise = random.Random(self.seed * JOINT_COUNT + joint)
        return WiredBoard(self.arm, joint, q, wiring, noise)

    @property
    def laws(self) -> tuple[TorqueLaw, ...]:
        """The torque laws its joints follow: the truth an experiment is to find."""
        boards = [self.arm.board_scale(joint) for joint in range(JOINT_COUNT)]
        return tuple(
            TorqueLaw.of(abs(board.torque_per_dac_code), friction, self._offset(joint))
            for joint, (board, friction) in enumerate(zip(boards, self.friction, strict=True))
        )

    def _offset(self, joint: int) -> float:
        sign = 1.0 if self.arm.drives[joint].gear_ratio > 0.0 else -1.0
        return sign * self.wiring[joint].current_offset

    @property
    def rigid(self) -> Arm:
        """The arm with its links as the physics engine has them, corrections made."""
        links = tuple(
            Link(link.physical_mass, link.com, link.physical_inertia) for link in self.arm.links
        )
        return replace(self.arm, links=links)


def as_built(arm: Arm, friction: str) -> Variant:
    """The arm of the data sheet with one of its friction sets."""
    return Variant("nominal", arm, friction_set(arm, friction))


def make_variant(name: str, arm: Arm, friction: str) -> Variant:
    """The plant called ``name``, of an arm; ``friction`` names the set it starts from.

    Raises:
        PlantError: there is none of that name.
        ArmError: there is no such friction set.
    """
    kind, loaded, rest = name.partition(WITH_LOAD)
    word, given, seed = kind.partition(SEPARATOR)
    make = _KINDS.get((word, bool(given)))
    if rest or make is None or (given and not (seed.isascii() and seed.isdecimal())):
        raise PlantError(f"no plant {name!r}; there are: {NAMES}; SEED is a whole number")
    variant = make(as_built(arm, friction), int(seed or 0))
    return replace(variant, name=name, load=known_load(arm) if loaded else NOTHING)


def _nominal(variant: Variant, _: int) -> Variant:
    return variant


def _table41(variant: Variant, _: int) -> Variant:
    laws = table_4_1(variant.arm)
    friction = tuple(law.friction for law in laws)
    wiring = (NOISY,) * JOINT_COUNT
    return replace(variant, arm=driven_by(variant.arm, laws), friction=friction, wiring=wiring)


def _rewired(variant: Variant, seed: int) -> Variant:
    draw = random.Random(seed)

    def about_one(part: float) -> float:
        return draw.uniform(1.0 - part, 1.0 + part)

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
    wiring = [NOISY] * JOINT_COUNT
    wiring[biased] = replace(NOISY, current_offset=offset)
    arm = replace(variant.arm, links=links, drives=drives)
    return replace(variant, arm=arm, friction=friction, wiring=tuple(wiring), seed=seed)


def _perturbed(variant: Variant, seed: int) -> Variant:
    rewired = _rewired(variant, seed)
    wiring = list(rewired.wiring)
    straight = [joint for joint in range(JOINT_COUNT) if not wiring[joint].current_offset]
    backwards = random.Random(~seed).choice(straight)
    wiring[backwards] = replace(wiring[backwards], encoder_sign=-1)
    return replace(rewired, wiring=tuple(wiring))


def _heavier(link: Link, factor: float) -> Link:
    """A link of another density: mass and inertia times ``factor``, as the physics has them."""
    xx, yy, zz = (factor * inertia for inertia in link.physical_inertia)
    return Link(factor * link.physical_mass, link.com, (xx, yy, zz))


_KINDS: Final[dict[tuple[str, bool], Callable[[Variant, int], Variant]]] = {
    ("nominal", False): _nominal,
    ("table41", False): _table41,
    ("rewired", True): _rewired,
    ("perturbed", True): _perturbed,
}
"""By word, and whether a seed follows."""
