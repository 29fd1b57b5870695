"""Bounds of what detectors watch, as the nodes are told them; and what each quantity is.

A quantity without a bound is there for those who choose one.
"""

from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

from rfms_can.arm import ARMS, arm_by_name
from rfms_can.arm.board_scale import CONVERTER_CODES
from rfms_can.joint_nodes.detectors.plausible_rows import GRAVITY_STEP, INERTIA_FACTOR
from rfms_can.joint_nodes.sensing import HARD_MARGIN_RAD
from rfms_can.master.start_up.node_parameters import joint_parameters
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.vocabulary import Parameter

Values = Mapping[Parameter, float]


class Quantity(NamedTuple):
    """What is measured.

    Attributes:
        meaning: in a line.
        bound: of one joint by its parameters, or None.
        needs: parameters that the bound is made of; without one of them there is no bound.
    """

    meaning: str
    bound: Callable[[Values], float] | None = None
    needs: tuple[str, ...] = ()


def _named(name: str) -> Parameter:
    return Parameter[name]


QUANTITIES: Final[Mapping[str, Quantity]] = {
    "speed": Quantity(
        "measured speed over the speed limit",
        lambda p: p[Parameter.OVERSPEED_LIMIT] / p[Parameter.SPEED_LIMIT],
    ),
    "sensors apart": Quantity(
        "cumulative sum of encoder rate less tachometer, less 5 % and 1 % of the limit; over the "
        "speed limit, cycles",
        lambda p: 3.0 * p[Parameter.TACHOMETER_LIMIT] / p[Parameter.SPEED_LIMIT],
    ),
    "varies at one code": Quantity(
        "spread of the ways of a cycle while the tachometer shows one code, over a tenth of the "
        "limit's and three counts",
        lambda _: 1.0,
    ),
    "encoder stands, 0.05": Quantity(
        "cycles of equal counts while the tachometer tells more than 0.05 of the limit",
    ),
    "tachometer stands, 0.05": Quantity(
        "cycles of one code while the encoder tells more than 0.05 of the limit",
    ),
    "current off, 1": Quantity("current ADC against the DAC that it shows, codes"),
    "current over, 1": Quantity(
        "the same beyond a tenth of the DAC, codes",
        lambda p: CONVERTER_CODES * p[_named("CURRENT_TOLERANCE")],
        ("CURRENT_TOLERANCE",),
    ),
    "speed error, 1": Quantity(
        "commanded less measured speed of a rigid joint, over the speed limit",
        lambda p: p[_named("RATE_ERROR_LIMIT")],
        ("RATE_ERROR_LIMIT",),
    ),
    "error over the master's": Quantity(
        "following error of a rigid joint over what the master allows it", lambda _: 1.0
    ),
    "error complying, rad": Quantity(
        "error of a joint while the arm complies, rad", lambda p: p[Parameter.FOLLOWING_ERROR_LIMIT]
    ),
    "torque": Quantity("commanded torque over the torque limit"),
    "stalls": Quantity(
        "cycles in a row at the torque limit and slower than 0.02 of the speed limit",
        lambda p: p[Parameter.STALL_TIME] / p[Parameter.PERIOD],
    ),
    "heat": Quantity(
        "heat of the motor over that of 5 s at the torque limit; 0.6 of it is borne for ever",
        lambda p: p[Parameter.OVERLOAD_TIME] / 5.0,
    ),
    "beyond range, rad": Quantity("distance beyond the range, rad", lambda _: HARD_MARGIN_RAD),
    "gravity": Quantity("gravity of the rows over the torque limit", lambda _: 1.0),
    "gravity step": Quantity(
        "its change from one set of rows to the next, over the torque limit", lambda _: GRAVITY_STEP
    ),
    "inertia over design": Quantity(
        "own inertia of the rows over that of the gains", lambda _: INERTIA_FACTOR
    ),
    "inertia step": Quantity("its relative change from one set of rows to the next"),
}
"""What the page tells of; the other quantities are in the file."""


def bound_of(name: str) -> float | None:
    """The least bound that a joint of any arm is told; None if there is none."""
    quantity = QUANTITIES.get(name)
    if quantity is None or quantity.bound is None:
        return None
    if any(needed not in Parameter.__members__ for needed in quantity.needs):
        return None
    bound, settings = quantity.bound, RunSettings()
    return min(
        bound(parameters[joint])
        for arm in ARMS
        for parameters in [
            joint_parameters(arm_by_name(arm), settings.friction, 1.0 / settings.rate)
        ]
        for joint in JOINTS
    )
