"""The Cartesian set-point of one cycle, sent by the master to the joints."""

from typing import NamedTuple

from rfms_can.kinematics import Configuration, Joints
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState


class CartesianSetpoint(NamedTuple):
    """The master's set-point of a cycle; the last five attributes are not sent.

    Attributes:
        state: the row of Table 3.3.
        mode: of the current segment; at START already the new one's.
        blend: which matching polynomial the joints use.
        r: 1 - h, 1 at the start of a segment, 0 at its goal.
        p: position in the transition (3.14), 0 to 1; also in a Cartesian one, which is LINEAR. At
            START the elapsed part of the transition, 0 at full speed; 1 after a Cartesian one into
            joint mode.
        acceleration_time: t_acc, s; with a feed rate what it takes at the feed of the hand-over.
        T6_1: the pose: of the goal in joint mode, of the hand in Cartesian mode. At START the
            pose B the new segment starts from.
        configuration_1: the branch ``T6_1`` is to be solved in.
        T6_2: the second pose, or None. In IDLE and PRE the ``T6_1`` of the next segment, so that
            its rate is known; at START of a joint segment its goal C.
        configuration_2: the branch ``T6_2`` is to be solved in.
        n: local time in periods, -n_acc to n_seg: whole at full speed.
        h: the segment parameter (3.15, 3.16).
        sequence: sequence number of the current move, 0 before the first.
        near_1, near_2: joint angles, rad, on whose turns the solution of ``T6_1`` or ``T6_2`` is;
            theta4 is theirs where a straight wrist leaves it open. None where they continue those
            of the cycle before. Joints that could not know are told the solution.
    """

    state: TrajectoryState
    mode: Mode
    blend: Blend
    r: float
    p: float
    acceleration_time: float
    T6_1: Transform
    configuration_1: Configuration
    T6_2: Transform | None
    configuration_2: Configuration
    n: float = 0
    h: float = 0.0
    sequence: int = 0
    near_1: Joints | None = None
    near_2: Joints | None = None
