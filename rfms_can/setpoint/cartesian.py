"""The Cartesian set-point of one cycle: what the master tells the joints."""

from typing import NamedTuple

from rfms_can.kinematics import Configuration
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState


class CartesianSetpoint(NamedTuple):
    """What the master sends each cycle, and (last three) what it remembers of it.

    Attributes:
        state: the row of Table 3.3.
        mode: of the segment under way; at START already the new one's.
        blend: which matching polynomial the joints use.
        r: 1 - h, 1 at the start of a segment, 0 at its goal.
        p: position in the transition (3.14), 0 to 1; also in a Cartesian one, which is LINEAR. At
            START how far the hand-over is past already, 0 at full speed.
        acceleration_time: t_acc, s; with a feed rate what it takes at the feed of the hand-over.
        T6_1: the pose: of the goal in joint mode, of the hand in Cartesian mode. At START the
            pose B the new segment starts from.
        configuration_1: the branch ``T6_1`` is to be solved in.
        T6_2: the second pose, None where there is none. In IDLE and PRE the one that the next
            segment will have as its ``T6_1``, so that its rate is known; at START of a joint
            segment its goal C.
        configuration_2: the branch ``T6_2`` is to be solved in.
        n: local time in periods, -n_acc to n_seg: whole at full speed.
        h: the segment parameter (3.15, 3.16).
        sequence: sequence number of the move under way, 0 before the first.
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
