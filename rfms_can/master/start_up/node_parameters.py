"""What each node is told before it is enabled: scales and limits of its board, gains of its servo.

Gains follow from two numbers, the same for every joint so that the arm behaves alike in all
directions: natural frequency and damping of the error, on the inertia the joint has at the park
pose. The natural frequency falls with slow control rates: sample time and the one period of bus
delay take phase in proportion.
"""

import math
import struct
from typing import Final

from rfms_can.arm import Arm, friction_set
from rfms_can.arm.calibration import Calibration, JointCalibration
from rfms_can.arm.components import Drive
from rfms_can.dynamics.model import NONE
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.master.settings import MasterSettings
from rfms_can.master.trajectory.braking import STOPPING_FRACTION
from rfms_can.wire.configuration import (
    PARAMETERS,
    Clock,
    DhRow,
    Kinematics,
    geometry_values,
)
from rfms_can.wire.nodes import GRIPPER, JOINTS, PLANT
from rfms_can.wire.vocabulary import Parameter

NATURAL_FREQUENCY: Final = 30.0
"""Of the error, rad/s, where the control period allows it."""
PERIOD_ANGLE: Final = 0.15
"""Most angle, rad, the natural frequency may turn in one control period: delay costs phase."""
DAMPING_RATIO: Final = 1.0
INTEGRAL_RATE: Final = 8.0
"""K_i over K_p, 1/s."""
INTEGRAL_FRACTION: Final = 0.3
"""Fraction of the torque limit the integral may use."""
DEADBAND_COUNTS: Final = 1.5
"""Error, encoder counts, the integral leaves alone: stiction would make it hunt."""
FRICTION_SPEED: Final = 2e-4
"""Desired speed, rad/s, up to which a joint counts as resting: friction keeps its last sign."""
HOMING_FRACTION: Final = 0.2
"""Homing speed over the joint's speed limit."""
DITHER_PERIODS_S: Final = (0.016, 0.024, 0.040, 0.024, 0.016, 0.040)
"""Of the dither, s, joint by joint: four to ten cycles at 250 Hz; a joint it frees moves a fraction
of a millimetre. They differ, so that each pair of joints is free to move the same way and opposite
ways in turn: with one period for all a peg can not turn in its hole, which takes both."""

# Bounds of the detectors (docs/node-detectors.md); docs/soak.md has what sound runs come to.
FOLLOWING_ERROR_RAD: Final = 0.2
OVERSPEED_FRACTION: Final = 1.25
"""Measured speed over the speed limit; what catches up with a moving goal may do 1.05."""
TACHOMETER_FRACTION: Final = 0.08
"""Difference of tachometer and encoder over the speed limit, beyond what a sound tachometer may be
off, that is found in three cycles: a hundredth of the limit is found in 25."""
CONTINUOUS_FRACTION: Final = 0.6
"""Torque that a motor bears for ever over the torque limit."""
OVERLOAD_S: Final = 5.0
"""How long the torque limit may be asked for; a motor's winding has a time constant of a minute."""
STALL_S: Final = 0.5
STUCK_CYCLES: Final = 25
CURRENT_TOLERANCE: Final = 0.035
"""Of the current that is driven against what the DACs ask, over full scale: offset of an amplifier
(60 codes) and of a converter (11), before they are identified."""
RATE_ERROR_LIMIT: Final = 0.2
"""Error of a rigid joint's speed that lasts, over the speed limit, at ``NATURAL_FREQUENCY``: 0.12
is the most that sound joints leave, at full speed with friction half as much again as known."""
UNMODELLED_RATE_ERROR: Final = 2.0
"""The same of servos that compensate nothing, over that: identification leaves 0.25."""
HOMING_MARGIN: Final = 4.0
"""Time limit of homing over the time to pass two indexes."""
GRIPPER_HOMING_S: Final = 5.0

Parameters = dict[Parameter, float]
_FRICTION: Final = (Parameter.COULOMB_POSITIVE, Parameter.COULOMB_NEGATIVE, Parameter.VISCOUS)


def joint_parameters(
    arm: Arm, friction_name: str, period_s: float, dither: float = 0.0
) -> dict[int, Parameters]:
    """Parameters of joint nodes 1 to 6.

    Args:
        arm: the arm on the bus.
        friction_name: friction set the servos compensate.
        period_s: control period, s.
        dither: fraction of the friction that complying joints dither with.
    """
    inertia = ArmDynamics(arm).inertia_matrix(arm.park)
    frictions = friction_set(arm, friction_name)
    natural = min(NATURAL_FREQUENCY, PERIOD_ANGLE / period_s)
    geometry = geometry_values(tuple(DhRow(a, d, alpha) for alpha, a, d in arm.dh))
    result: dict[int, Parameters] = {}
    for joint in JOINTS:
        i = joint - 1
        drive, scale, friction = arm.drives[i], arm.board_scale(i), frictions[i]
        stiffness = float(inertia[i, i]) * natural**2
        counts_per_rad = drive.counts_per_radian
        result[joint] = {
            Parameter.ARM_ID: float(arm.arm_id),
            Parameter.PERIOD: period_s,
            Parameter.KP: stiffness,
            Parameter.KI: INTEGRAL_RATE * stiffness,
            Parameter.KD: 2.0 * DAMPING_RATIO * float(inertia[i, i]) * natural,
            Parameter.INTEGRAL_LIMIT: INTEGRAL_FRACTION * drive.torque_limit,
            Parameter.INTEGRAL_DEADBAND: DEADBAND_COUNTS / abs(counts_per_rad),
            Parameter.NATURAL_FREQUENCY: natural,
            Parameter.DAMPING_RATIO: DAMPING_RATIO,
            Parameter.TORQUE_LIMIT: drive.torque_limit,
            Parameter.TORQUE_PER_CODE: scale.torque_per_dac_code,
            Parameter.COUNTS_PER_UNIT: counts_per_rad,
            Parameter.RATE_PER_CODE: scale.speed_per_adc_code,
            Parameter.COULOMB_POSITIVE: friction.coulomb_positive,
            Parameter.COULOMB_NEGATIVE: friction.coulomb_negative,
            Parameter.VISCOUS: friction.viscous,
            Parameter.FRICTION_SPEED: FRICTION_SPEED,
            Parameter.POSITION_MIN: arm.joint_limits[i][0],
            Parameter.POSITION_MAX: arm.joint_limits[i][1],
            Parameter.SPEED_LIMIT: arm.speed_limits[i],
            Parameter.ACCELERATION_LIMIT: STOPPING_FRACTION * arm.acceleration_limits[i],
            Parameter.COARSE_PER_CODE: scale.angle_per_coarse_code,
            Parameter.COARSE_ZERO: scale.coarse_zero,
            Parameter.INDEX_INTERVAL_COUNTS: float(drive.counts_per_revolution),
            Parameter.HOMING_SPEED: HOMING_FRACTION * arm.speed_limits[i],
            Parameter.DITHER_FRACTION: dither,
            Parameter.DITHER_PERIOD: DITHER_PERIODS_S[i],
            Parameter.TORQUE_PER_FORCE_CODE: scale.torque_per_force_code,
            Parameter.KINEMATICS: float(Kinematics.SPHERICAL_WRIST),
            Parameter.FOLLOWING_ERROR_LIMIT: FOLLOWING_ERROR_RAD,
            Parameter.OVERSPEED_LIMIT: OVERSPEED_FRACTION * arm.speed_limits[i],
            Parameter.TACHOMETER_LIMIT: TACHOMETER_FRACTION * arm.speed_limits[i],
            Parameter.CONTINUOUS_TORQUE: CONTINUOUS_FRACTION * drive.torque_limit,
            Parameter.OVERLOAD_TIME: OVERLOAD_S,
            Parameter.STALL_TIME: STALL_S,
            Parameter.STUCK_TIME: STUCK_CYCLES * period_s,
            Parameter.CURRENT_TOLERANCE: CURRENT_TOLERANCE,
            Parameter.RATE_ERROR_LIMIT: _rate_error_limit(natural),
            Parameter.HOMING_TIME: HOMING_MARGIN * _index_travel_s(drive, arm.speed_limits[i]),
            **geometry,
        }
    return result


def gripper_parameters(arm: Arm, period_s: float) -> Parameters:
    """Parameters of the gripper node; its unit is the metre."""
    gripper = arm.gripper
    return {
        Parameter.ARM_ID: float(arm.arm_id),
        Parameter.PERIOD: period_s,
        Parameter.TORQUE_LIMIT: gripper.force_limit,
        Parameter.TORQUE_PER_CODE: gripper.force_per_dac_code,
        Parameter.COUNTS_PER_UNIT: gripper.counts_per_metre,
        Parameter.POSITION_MAX: gripper.stroke,
        Parameter.HOMING_TIME: GRIPPER_HOMING_S,
    }


def bus_parameters(clock: Clock, barrier_s: float) -> Parameters:
    """What a node is told of the bus: which clock SYNC follows, and who sends its samples."""
    return {
        Parameter.CLOCK: float(clock),
        Parameter.BARRIER: barrier_s,
        Parameter.SENSOR_SOURCE: float(PLANT),
    }


def _rate_error_limit(natural: float, factor: float = 1.0) -> float:
    """RATE_ERROR_LIMIT of a servo of a natural frequency, rad/s: a softer one leaves more."""
    softness = NATURAL_FREQUENCY / natural
    return min(PARAMETERS[Parameter.RATE_ERROR_LIMIT].high, RATE_ERROR_LIMIT * factor * softness)


def _index_travel_s(drive: Drive, speed_limit: float) -> float:
    """Time to pass two indexes at homing speed, s: one may lie right behind the joint."""
    interval_rad = drive.counts_per_revolution / abs(drive.counts_per_radian)
    return 2.0 * interval_rad / (HOMING_FRACTION * speed_limit)


def all_parameters(
    arm: Arm,
    friction_name: str,
    period_s: float,
    calibration: Calibration | None = None,
    *,
    compensated: bool = True,
    dither: float = 0.0,
    clock: Clock = Clock.VIRTUAL,
    barrier_s: float = 2.0,
) -> dict[int, Parameters]:
    """Parameters of nodes 1 to 7, rounded to the float32 they travel as.

    Args:
        arm: the arm on the bus.
        friction_name: friction set the servos compensate, where no calibration says better.
        period_s: control period, s.
        calibration: torque per code and friction as they were measured.
        compensated: whether the servos compensate friction at all.
        dither: fraction of the friction that complying joints dither with.
        clock, barrier_s: see ``MasterSettings``.
    """
    nodes = joint_parameters(arm, friction_name, period_s, dither)
    if calibration is not None:
        for joint in JOINTS:
            nodes[joint].update(_measured(calibration.joints[joint - 1], nodes[joint]))
    if not compensated:
        for joint in JOINTS:
            nodes[joint].update(dict.fromkeys(_FRICTION, 0.0))
            natural = nodes[joint][Parameter.NATURAL_FREQUENCY]
            nodes[joint][Parameter.RATE_ERROR_LIMIT] = _rate_error_limit(
                natural, UNMODELLED_RATE_ERROR
            )
    nodes[GRIPPER] = gripper_parameters(arm, period_s)
    for parameters in nodes.values():
        parameters.update(bus_parameters(clock, barrier_s))
    number = struct.Struct("<f")
    return {
        node: {p: number.unpack(number.pack(v))[0] for p, v in parameters.items()}
        for node, parameters in nodes.items()
    }


def parameters_for(arm: Arm, settings: MasterSettings) -> dict[int, Parameters]:
    """Parameters of nodes 1 to 7 as a master's settings have them."""
    return all_parameters(
        arm,
        settings.friction,
        settings.period_ns * 1e-9,
        settings.calibration,
        compensated=settings.dynamics != NONE,
        dither=settings.dither,
        clock=settings.clock,
        barrier_s=settings.barrier_s,
    )


def _measured(joint: JointCalibration, nominal: Parameters) -> Parameters:
    """What the node is told of a torque law: it knows one slope, for either direction.

    Offsets are scaled so that the current of a joint without load is exact; with load the error is
    half the difference of the slopes.
    """
    law = joint.law
    return {
        Parameter.TORQUE_PER_CODE: math.copysign(law.slope, nominal[Parameter.TORQUE_PER_CODE]),
        # friction that was measured below zero is none
        Parameter.COULOMB_POSITIVE: max(0.0, -law.offset_positive * law.slope / law.slope_positive),
        Parameter.COULOMB_NEGATIVE: max(0.0, law.offset_negative * law.slope / law.slope_negative),
        Parameter.VISCOUS: max(0.0, law.viscous),
    }
