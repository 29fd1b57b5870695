"""What a mode may say of how a segment is moved."""

from typing import Literal, Required, TypedDict


class ModeSettings(TypedDict, total=False):
    """How a segment is moved (thesis VI.3.1).

    The time of a segment is given, or follows from speeds: the longest any of them asks for.

    Attributes:
        acceleration_time: t_acc, s: a transition takes twice that.
        segment_time: t_seg, s, from goal to goal; or speeds instead.
        speed, angular_speed: of the tool from goal to goal, m/s and rad/s.
        joint_speed: part (0 to 1) of the joints' speed limits.
        interpolation: ``"joint"``, the default, or ``"cartesian"``: straight in space.
        transition: ``"joint"``, the default, or ``"cartesian"``: between straight lines keep to
            the path in space.
        lengthen: whether a segment that breaks a limit is lengthened, or refused, the default.
        acceleration, angular_acceleration: what correcting a reference transform may add to the
            tool's motion, m/s2 and rad/s2; 1 and 5 if not given.
        config: e.g. ``"left up noflip"``, instead of the position's.
        comply: what complies, and the bias force or moment along each direction, N or N m, e.g.
            ``{"fx": 0.0, "fz": 20.0}``; what :meth:`Arm.comply` has asked for if not given. What
            it exerts on what the tool touches is positive.
        stop_on_force: e.g. ``{"fz": 15.0}``: the move is stopped where the force along a direction
            of the compliance frame reaches this, N or N m, in either sense.
        stop_on_distance: e.g. ``{"dz": 0.04}``: where the compliance frame has gone so far since
            the move took over, m or rad.
        mass: of what the hand holds from this move on, kg, compensated for; 0 for nothing, what it
            held before if not given.
        mass_centre: its centre of mass in T6, m; the origin of the tool's frame if not given.
    """

    acceleration_time: Required[float]
    segment_time: float | None
    speed: float | None
    angular_speed: float | None
    joint_speed: float | None
    interpolation: Literal["joint", "cartesian"]
    transition: Literal["joint", "cartesian"]
    lengthen: bool
    acceleration: float
    angular_acceleration: float
    config: str | None
    comply: dict[str, float] | None
    stop_on_force: dict[str, float] | None
    stop_on_distance: dict[str, float] | None
    mass: float | None
    mass_centre: tuple[float, float, float] | None
