"""The numbers of the PUMA 560 and the PUMA 260: geometry, limits, links and drive trains.

Every number has its source and its reliability:

* **S** read in the named source; **D** derived here; **R** recalled from the literature, not
  re-verified; **P** our proposal.

Sources: *toolbox*, roboticstoolbox 1.5.0 ``models/DH/Puma560.py`` (Corke and Armstrong-Helouvry
1994; *AKB*: Armstrong, Khatib, Burdick 1986); *thesis*, Table 4.1 and Appendix A; *YARP*,
``YARPGALILOnEurobotArmAdapter.h``; *Penn*, MEAM520. Wrist coupling is ignored, as in the thesis:
each encoder counts its own joint.
"""

from collections.abc import Mapping
from math import radians
from types import MappingProxyType
from typing import Final

from rfms_can.arm.components import Correction, Drive, JointFriction, Link
from rfms_can.arm.mechanism import JOINT_COUNT, Arm, Gripper

OUNCE_INCH: Final = 7.0615518e-3  # Nm


def _limits_deg(*pairs: tuple[float, float]) -> tuple[tuple[float, float], ...]:
    return tuple((radians(lower), radians(upper)) for lower, upper in pairs)


# S toolbox, axes of the link frame. Two published inertias belong to no rigid body:
_LINKS_560: Final = (
    Link(
        0.0,
        (0.0, 0.0, 0.0),
        (0.0, 0.35, 0.0),
        Correction(
            13.0,  # R: mass of the trunk; on the joint-1 axis it changes no torque
            (0.35, 0.35, 0.35),
            "published without mass and with yy alone; only yy (about the joint axis) acts",
        ),
    ),
    Link(17.4, (-0.3638, 0.006, 0.2275), (0.13, 0.524, 0.539)),
    Link(
        4.8,
        (-0.0203, -0.0141, 0.070),
        (0.066, 0.086, 0.0125),
        Correction(
            4.8,
            (0.066, 0.066 + 0.0125, 0.0125),
            "published yy = 0.086 exceeds xx + zz = 0.0785, which no mass distribution can",
        ),
    ),
    # S AKB: 19 mm towards the elbow; the toolbox prints +0.019, a slip of sign.
    Link(0.82, (0.0, -0.019, 0.0), (0.0018, 0.0013, 0.0018)),
    Link(0.34, (0.0, 0.0, 0.0), (0.0003, 0.0004, 0.0003)),
    Link(0.09, (0.0, 0.0, 0.032), (0.00015, 0.00015, 0.00004)),
)

# Gear and rotor inertia S toolbox (Corke); torque limit R AKB; Kt R Corke 1996; counts per motor
# revolution P: 1000 everywhere, as the sources contradict one another (1000 or 800).
_DRIVES_560: Final = (
    Drive(-62.6111, 200e-6, 97.6, 0.223, 1000),
    Drive(107.815, 200e-6, 186.4, 0.226, 1000),
    Drive(-53.7063, 200e-6, 89.4, 0.240, 1000),
    Drive(76.0364, 33e-6, 24.2, 0.069, 1000),
    Drive(71.923, 33e-6, 20.1, 0.072, 1000),
    Drive(76.686, 33e-6, 21.3, 0.066, 1000),
)

# S toolbox, motor-side: viscous Nms/rad, Coulomb Nm for positive and negative *joint* velocity
# (the toolbox multiplies by |G| and takes the sign of the joint's velocity).
_MOTOR_FRICTION_560: Final = (
    (1.48e-3, 0.395, 0.435),
    (0.817e-3, 0.126, 0.071),
    (1.38e-3, 0.132, 0.105),
    (71.2e-6, 11.2e-3, 16.9e-3),
    (82.6e-6, 9.26e-3, 14.5e-3),
    (36.7e-6, 3.96e-3, 10.5e-3),
)

# S thesis Table 4.1: offsets -B_p and B_n in oz-in: the torque motion costs in either direction.
_THESIS_OFFSETS_560: Final = (
    (2017.0, 1800.0),
    (1088.0, 1280.0),
    (642.0, 671.0),
    (116.0, 111.0),
    (101.0, 146.0),
    (96.0, 88.0),
)


def _friction_sets_560() -> Mapping[str, tuple[JointFriction, ...]]:
    """Friction sets of the 560; the thesis gives no viscous friction, Corke's is used (D)."""
    corke = tuple(
        JointFriction(
            positive * abs(drive.gear_ratio),
            negative * abs(drive.gear_ratio),
            viscous * drive.gear_ratio**2,
        )
        for drive, (viscous, positive, negative) in zip(
            _DRIVES_560, _MOTOR_FRICTION_560, strict=True
        )
    )
    thesis = tuple(
        JointFriction(positive * OUNCE_INCH, negative * OUNCE_INCH, joint.viscous)
        for (positive, negative), joint in zip(_THESIS_OFFSETS_560, corke, strict=True)
    )
    none = (JointFriction(0.0, 0.0, 0.0),) * JOINT_COUNT
    return MappingProxyType({"corke": corke, "thesis": thesis, "none": none})


# P: a small electric gripper: 0.25 m/s at full force, closed in a third of a second.
_GRIPPER: Final = Gripper(
    stroke=0.08, mass=0.4, friction=160.0, force_limit=40.0, counts_per_metre=100_000.0
)

_PARK: Final = (0.1, 1.4, -3.3, 0.1, -1.25, 0.1)
"""P: elbow above, forearm forward, hand down; thesis "left", "down" (C3 < 0), "flip" (S5 < 0)."""

PUMA_560: Final = Arm(
    name="puma560",
    arm_id=560,
    a2=0.4318,  # S toolbox, like all lengths but the flange
    a3=0.0203,
    d2=0.0,
    d3=0.15005,
    d4=0.4318,
    flange=0.05625,  # R
    joint_limits=_limits_deg(  # S toolbox
        (-160.0, 160.0),
        (-45.0, 225.0),
        (-225.0, 45.0),
        (-110.0, 170.0),
        (-100.0, 100.0),
        (-266.0, 266.0),
    ),
    speed_limits=(1.4, 0.9, 2.1, 3.9, 4.2, 3.9),  # P: size of the maker's data sheet
    acceleration_limits=(6.0, 6.0, 12.0, 40.0, 40.0, 40.0),  # P
    links=_LINKS_560,
    drives=_DRIVES_560,
    friction_sets=_friction_sets_560(),
    park=_PARK,
    gripper=_GRIPPER,
)

# P: no inertia, friction or torque of the 260 was ever published. The 560 is scaled by the ratio
# of the arm lengths, 8 in to 17 in, as castings of constant wall thickness: masses as s^2,
# lengths as s, inertias as s^4, torques as s^3 (same time scale, same ratio of gravity to
# torque). Treat the masses as +-50 %.
_SCALE: Final = 8.0 / 17.0


def _scaled_link(link: Link) -> Link:
    """The link of a constant-wall-thickness arm ``_SCALE`` times as long."""
    x, y, z = (_SCALE * c for c in link.com)
    xx, yy, zz = (_SCALE**4 * i for i in link.inertia)
    correction = None
    if link.correction is not None:
        cx, cy, cz = (_SCALE**4 * i for i in link.correction.inertia)
        correction = Correction(
            _SCALE**2 * link.correction.mass, (cx, cy, cz), link.correction.reason + " (scaled)"
        )
    return Link(_SCALE**2 * link.mass, (x, y, z), (xx, yy, zz), correction)


def _with_com(link: Link, *, x: float | None = None, z: float | None = None) -> Link:
    """The link with one coordinate of its centre of mass replaced."""
    com = (link.com[0] if x is None else x, link.com[1], link.com[2] if z is None else z)
    return Link(link.mass, com, link.inertia, link.correction)


def _links_260() -> tuple[Link, ...]:
    """The 560's links scaled, with the two structural differences of the 260."""
    one, two, three, *wrist = (_scaled_link(link) for link in _LINKS_560)
    return (
        one,
        _with_com(two, z=-0.0635),  # frame 2 lies in the forearm's plane, upper arm 2.5 in inboard
        _with_com(three, x=0.0),  # a3 = 0
        *wrist,
    )


_TORQUE_LIMITS_260: Final = tuple(_SCALE**3 * drive.torque_limit for drive in _DRIVES_560)

# Gear and counts S YARP. Rotor inertia and Kt P: the 560's wrist motor on joints 1 to 3 (the
# scaled armature asks for its size, the current stays inside 5 A), a smaller one on the wrist.
_DRIVES_260: Final = (
    Drive(-46.72, 33e-6, _TORQUE_LIMITS_260[0], 0.069, 1000),
    Drive(69.9733, 33e-6, _TORQUE_LIMITS_260[1], 0.069, 1000),
    Drive(-42.9867, 33e-6, _TORQUE_LIMITS_260[2], 0.069, 1000),
    Drive(43.5111, 6e-6, _TORQUE_LIMITS_260[3], 0.03, 800),
    Drive(39.3846, 6e-6, _TORQUE_LIMITS_260[4], 0.03, 800),
    Drive(31.7692, 6e-6, _TORQUE_LIMITS_260[5], 0.03, 800),
)

PUMA_260: Final = Arm(
    name="puma260",
    arm_id=260,
    a2=0.2032,  # S thesis Appendix A, like all lengths
    a3=0.0,
    d2=0.12623,
    d3=0.0,
    d4=0.2032,
    flange=0.0554,
    joint_limits=_limits_deg(  # spans S Penn; centred and mirrored to the thesis' frames D
        (-145.0, 145.0),
        (-60.0, 255.0),
        (-240.0, 55.0),
        (-310.0, 310.0),
        (-115.0, 115.0),
        (-255.0, 255.0),
    ),
    speed_limits=(2.0, 1.5, 2.0, 4.0, 4.0, 5.0),  # P
    acceleration_limits=(10.0, 10.0, 20.0, 40.0, 40.0, 40.0),  # P
    links=_links_260(),
    drives=_DRIVES_260,
    friction_sets=MappingProxyType(
        {
            name: tuple(joint.scaled(_SCALE**3) for joint in joints)
            for name, joints in PUMA_560.friction_sets.items()
        }
    ),
    park=_PARK,
    gripper=_GRIPPER,
)
