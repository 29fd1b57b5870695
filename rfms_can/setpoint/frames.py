"""Set-points on the wire: packed by the master into SETPOINT 1 and 2, unpacked by the nodes."""

import struct
from functools import lru_cache
from typing import Final

from rfms_can.kinematics import CONFIGURATIONS, Configuration, Joints
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.transform import Transform
from rfms_can.wire.records import Setpoint
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

_POSE: Final = struct.Struct("<9f")
_HEAD: Final = struct.Struct("<3f")
_ANGLES: Final = struct.Struct("<6f")
_STATES: Final = tuple(TrajectoryState)
_MODES: Final = tuple(Mode)
_BLENDS: Final = tuple(Blend)


def values_of(
    setpoint: CartesianSetpoint,
    pose: Transform,
    configuration: Configuration,
    cycle: int,
    extras: int = 0,
) -> tuple[float, ...]:
    """The values of one SETPOINT frame: ``pose`` is T6_1 or T6_2 of ``setpoint``."""
    return (
        *(pose.ox, pose.oy, pose.oz),
        *(pose.ax, pose.ay, pose.az),
        *(pose.px, pose.py, pose.pz),
        *(setpoint.r, setpoint.p, setpoint.acceleration_time),
        *(setpoint.state, setpoint.mode, configuration.code, setpoint.blend),
        *(cycle, setpoint.sequence & 0xFFFF, 1 if setpoint.T6_2 is None else 2, extras),
    )


def as_received(setpoint: CartesianSetpoint) -> CartesianSetpoint:
    """``setpoint`` as the joints receive it: poses, r, p and t_acc in float32."""
    r, p, t_acc = _HEAD.unpack(_HEAD.pack(setpoint.r, setpoint.p, setpoint.acceleration_time))
    second = setpoint.T6_2
    return setpoint._replace(
        r=r,
        p=p,
        acceleration_time=t_acc,
        T6_1=_received(setpoint.T6_1),
        T6_2=None if second is None else _received(second),
    )


def angles_as_received(angles: Joints) -> Joints:
    """Joint angles, rad, as JOINT_SETPOINT carries them: in float32."""
    q1, q2, q3, q4, q5, q6 = _ANGLES.unpack(_ANGLES.pack(*angles))
    return (q1, q2, q3, q4, q5, q6)


def _elements(pose: Transform) -> tuple[float, ...]:
    _, ox, ax, px, _, oy, ay, py, _, oz, az, pz = pose
    return (ox, oy, oz, ax, ay, az, px, py, pz)


@lru_cache(maxsize=4)
def _received(pose: Transform) -> Transform:
    """A pose of float32; in joint mode it is the same from cycle to cycle."""
    e = _POSE.unpack(_POSE.pack(*_elements(pose)))
    return Transform.from_o_a_p(e[0:3], e[3:6], e[6:9])


@lru_cache(maxsize=4)
def setpoint_of(first: Setpoint, second: Setpoint | None) -> CartesianSetpoint:
    """The set-point of the frames; a pure function, so nodes of one process share its results."""
    return CartesianSetpoint(
        state=_STATES[first.state],
        mode=_MODES[first.mode],
        blend=_BLENDS[first.blend],
        r=first.r,
        p=first.blend_p,
        acceleration_time=first.acceleration_time,
        T6_1=Transform.from_o_a_p(first[0:3], first[3:6], first[6:9]),
        configuration_1=CONFIGURATIONS[first.configuration],
        T6_2=None
        if second is None
        else Transform.from_o_a_p(second[0:3], second[3:6], second[6:9]),
        configuration_2=CONFIGURATIONS[(first if second is None else second).configuration],
        sequence=first.sequence,
    )
