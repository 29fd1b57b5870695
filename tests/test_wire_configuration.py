"""The parameters of a node: what it takes, and the arm's geometry in numbers that stay exact."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.arm import ARMS, Arm
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.wire.configuration import (
    DEFAULTS,
    GRIPPER_PARAMETERS,
    JOINT_PARAMETERS,
    PARAMETERS,
    RIGHT_ANGLE_UNITS,
    DhRow,
    configuration_hash,
    contradiction,
    geometry_rows,
    geometry_values,
    sensor_sources,
)
from rfms_can.wire.nodes import GRIPPER, JOINTS
from rfms_can.wire.vocabulary import Parameter


def float32(value: float) -> float:
    """As it arrives."""
    number: float = struct.unpack("<f", struct.pack("<f", value))[0]
    return number


def test_every_parameter_has_a_range_and_commit_has_none() -> None:
    assert set(PARAMETERS) == set(Parameter) - {Parameter.COMMIT}
    for parameter, known in PARAMETERS.items():
        assert known.low < known.high, parameter
        assert known.low > 0.0 or not known.signed, f"{parameter.name}: 0 has no sign"


@pytest.mark.parametrize("parameter", PARAMETERS, ids=lambda p: p.name)
def test_bounds_are_taken_and_what_lies_beyond_is_refused_with_them(parameter: Parameter) -> None:
    known = PARAMETERS[parameter]
    for bound, beyond in ((known.low, -1.0), (known.high, 1.0)):
        assert known.refusal(bound) is None
        over = bound + beyond * max(1.0, abs(bound)) * 0.5
        over = 0.0 if known.signed and beyond < 0.0 else over
        refusal = known.refusal(over)
        assert refusal is not None
        assert f"{known.low:g}..{known.high:g}" in refusal
        if known.signed:
            assert known.refusal(-bound) is None
    for value in (math.nan, math.inf, -math.inf):
        assert known.refusal(value) is not None
    if known.whole:
        assert known.refusal(known.low + 0.5) == f"{known.low + 0.5:g} {known.unit}: " + (
            "must be a whole number"
        )


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan])
def test_a_period_that_cannot_be_is_refused(value: float) -> None:
    assert PARAMETERS[Parameter.PERIOD].refusal(value) is not None


@pytest.mark.parametrize("arm", ARMS.values(), ids=lambda arm: arm.name)
def test_the_geometry_of_an_arm_crosses_the_wire_without_a_digit_lost(arm: Arm) -> None:
    rows = tuple(DhRow(a, d, alpha) for alpha, a, d in arm.dh)
    values = {p: float32(value) for p, value in geometry_values(rows).items()}
    assert all(PARAMETERS[p].refusal(value) is None for p, value in values.items())
    assert geometry_rows(values) == rows


@given(st.integers(-(2**24), 2**24), st.integers(-4 * RIGHT_ANGLE_UNITS, 4 * RIGHT_ANGLE_UNITS))
def test_every_whole_length_and_angle_is_exact(length_um: int, units: int) -> None:
    row = DhRow(length_um / 1e6, 0.0, units / RIGHT_ANGLE_UNITS * (math.pi / 2.0))
    values = {p: float32(value) for p, value in geometry_values((row,) * 6).items()}
    assert geometry_rows(values) == (row,) * 6


@pytest.mark.parametrize(
    ("row", "what"),
    [(DhRow(0.4318005, 0.0, 0.0), "micrometres"), (DhRow(0.0, 0.0, 1.5708), "1e-4 degrees")],
)
def test_a_geometry_between_two_units_is_refused(row: DhRow, what: str) -> None:
    with pytest.raises(ValueError, match=f"is not a whole number of {what}"):
        geometry_values((row,) * 6)


def test_right_angles_are_right() -> None:
    values = geometry_values((DhRow(0.0, 0.0, math.pi / 2.0),) * 6)
    assert values[Parameter.DH_ALPHA_1] == 900_000.0
    assert geometry_rows(values)[0].alpha == math.pi / 2.0


def test_the_gripper_needs_no_geometry() -> None:
    assert Parameter.PERIOD in GRIPPER_PARAMETERS
    assert not any(p.name.startswith("DH_") for p in GRIPPER_PARAMETERS)


def test_samples_come_from_the_plant_the_node_or_its_board() -> None:
    assert sensor_sources(3) == {9, 3, 13}
    assert sensor_sources(7) == {9, 7, 17}


def test_the_hash_is_a_crc_over_pairs_in_ascending_order() -> None:
    """By hand: CRC-16 0x1021 from 0xffff over 01 00000040 02 0000803f."""
    values = {Parameter.KP: 1.0, Parameter.PERIOD: 2.0}
    crc = 0xFFFF
    for byte in bytes.fromhex("01 00000040 02 0000803f"):
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    assert configuration_hash(values) == crc
    assert configuration_hash(dict(reversed(values.items()))) == crc
    driven = {Parameter.CLOCK: 1.0, Parameter.BARRIER: 0.5}
    assert configuration_hash({**values, **driven}) == crc  # the same on every bus


# --- parameters added since, and sets that contradict themselves ----------------------------------


def test_what_was_added_later_has_a_default_that_a_node_takes() -> None:
    """A master that does not know it configures the joint all the same."""
    assert set(DEFAULTS) == {Parameter.CURRENT_TOLERANCE, Parameter.RATE_ERROR_LIMIT}
    for parameter, value in DEFAULTS.items():
        assert PARAMETERS[parameter].refusal(value) is None
        assert not PARAMETERS[parameter].gripper
    assert JOINT_PARAMETERS | DEFAULTS.keys() == set(PARAMETERS)


@pytest.mark.parametrize("arm", ARMS.values(), ids=lambda arm: arm.name)
@pytest.mark.parametrize("period_s", [0.001, 0.004, 0.02])
@pytest.mark.parametrize("compensated", [True, False])
def test_what_a_master_tells_its_nodes_is_in_range_and_contradicts_nothing(
    arm: Arm, period_s: float, compensated: bool
) -> None:
    nodes = all_parameters(arm, "corke", period_s, compensated=compensated)
    for node in (*JOINTS, GRIPPER):
        assert contradiction(nodes[node]) is None
        for parameter, value in nodes[node].items():
            assert PARAMETERS[parameter].refusal(value) is None, parameter.name


BOUNDED = [
    (Parameter.POSITION_MIN, Parameter.POSITION_MAX, 1.0),
    (Parameter.INTEGRAL_LIMIT, Parameter.TORQUE_LIMIT, 1.0),
    (Parameter.CONTINUOUS_TORQUE, Parameter.TORQUE_LIMIT, 1.0),
    (Parameter.HOMING_SPEED, Parameter.SPEED_LIMIT, 1.0),
    (Parameter.TACHOMETER_LIMIT, Parameter.SPEED_LIMIT, 1.0),
    (Parameter.OVERSPEED_LIMIT, Parameter.SPEED_LIMIT, 1.5),
]


@pytest.mark.parametrize(("lesser", "greater", "factor"), BOUNDED)
def test_a_parameter_beyond_another_that_bounds_it_is_named_with_both(
    lesser: Parameter, greater: Parameter, factor: float
) -> None:
    assert contradiction({lesser: factor * 2.0, greater: 2.0}) is None
    assert contradiction({lesser: 9.0}) is None  # it is asked where both are there
    assert contradiction({greater: 2.0}) is None
    told = contradiction({lesser: factor * 2.0 * 1.0001, greater: 2.0})
    assert told is not None
    words = f"{factor:g} times " if factor != 1.0 else ""
    assert told.startswith(f"{lesser.name} ")
    assert told.endswith(f" is beyond {words}{greater.name} 2")


@given(st.floats(0.0078125, 100.0, width=32))
def test_a_multiple_is_taken_as_float32_rounds_it(limit: float) -> None:
    values = {Parameter.SPEED_LIMIT: limit, Parameter.OVERSPEED_LIMIT: float32(1.5 * limit)}
    assert contradiction(values) is None
    values[Parameter.OVERSPEED_LIMIT] = float32(1.50001 * limit)
    assert contradiction(values) is not None


@pytest.mark.parametrize(
    ("parameter", "largest"),
    [
        (Parameter.FOLLOWING_ERROR_LIMIT, 0.5),
        (Parameter.OVERSPEED_LIMIT, 150.0),
        (Parameter.TACHOMETER_LIMIT, 100.0),
        (Parameter.OVERLOAD_TIME, 60.0),
        (Parameter.STALL_TIME, 5.0),
        (Parameter.STUCK_TIME, 1.0),
        (Parameter.CURRENT_TOLERANCE, 0.25),
        (Parameter.RATE_ERROR_LIMIT, 0.5),
    ],
)
def test_no_master_can_switch_a_detector_off(parameter: Parameter, largest: float) -> None:
    """A bound has a largest value, whatever the master says."""
    known = PARAMETERS[parameter]
    assert (known.high, known.refusal(largest)) == (largest, None)
    for value in (0.0, 1.01 * largest, 1e9):
        assert known.refusal(value) is not None
