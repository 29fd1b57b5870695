"""Settings of a mode: the motion parameters of a segment."""

from typing import Literal, Required, TypedDict


class ModeSettings(TypedDict, total=False):
    """Motion parameters of a segment (thesis VI.3.1).

    The time of a segment is given, or follows from speeds: the longest of the resulting times.

    Attributes:
        acceleration_time: t_acc, s: a transition takes twice that.
        segment_time: t_seg, s, from goal to goal; or speeds instead.
        speed, angular_speed: of the tool from goal to goal, m/s and rad/s; with a speed alone, and
            no joint speed, the tool turns at speed / 0.2 m at most.
        joint_speed: fraction (0 to 1) of the joints' speed limits.
        interpolation: ``"joint"``, the default, or ``"cartesian"``: straight in space.
        transition: ``"joint"``, the default, or ``"cartesian"``: the transition is planned in
            space.
        deviation: largest distance of the tool from the position before, m, up to 1, where the arm
            does not rest there: the transition takes the longest time that keeps it.
        lengthen: whether a segment that exceeds a limit is lengthened, or refused, the default.
        lengthen_at_most: by which factor it may be lengthened, 10 if not given; a segment that
            needs more is refused, with the time it would take.
        acceleration, angular_acceleration: what correcting a reference transform may add to the
            tool's motion, m/s2 and rad/s2; 1 and 5 if not given.
        config: e.g. ``"left up noflip"``, instead of the position's.
        comply: compliant directions with the bias force or moment along each, N or N m, e.g.
            ``{"fx": 0.0, "fz": 20.0}``; those of :meth:`Arm.comply` if not given. A force on the
            environment is positive.
        stop_on_force: e.g. ``{"fz": 15.0}``: the move is stopped where the force along a direction
            of the compliance frame reaches this, N or N m, in either sense.
        stop_on_distance: e.g. ``{"dz": 0.04}``: the move is stopped after this displacement of the
            compliance frame since its start, m or rad.
        mass: payload from this move on, kg, to be compensated; 0 for none, unchanged if not given.
        mass_centre: its centre of mass in T6, m; the origin of the tool's frame if not given.
    """

    acceleration_time: Required[float]
    segment_time: float | None
    speed: float | None
    angular_speed: float | None
    joint_speed: float | None
    interpolation: Literal["joint", "cartesian"]
    transition: Literal["joint", "cartesian"]
    deviation: float | None
    lengthen: bool
    lengthen_at_most: float
    acceleration: float
    angular_acceleration: float
    config: str | None
    comply: dict[str, float] | None
    stop_on_force: dict[str, float] | None
    stop_on_distance: dict[str, float] | None
    mass: float | None
    mass_centre: tuple[float, float, float] | None
