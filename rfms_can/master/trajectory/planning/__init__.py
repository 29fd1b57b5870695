"""What happens to a move before it is accepted: how long, how fast, in how many parts.

``planner.py`` decides; ``times.py`` says how long a segment is to take, ``base_path.py`` and
``curve.py`` where the joints are along it, ``preview.py`` what they will do, ``limits.py`` whether
they may, ``search.py`` what would do instead, ``remedy.py`` and ``alternatives.py`` what may be
offered then, ``refusal.py`` tries it, ``large_rotation.py`` splits large rotations,
``via_deviation.py`` tells how far a transition stays from the position it cuts, ``corner.py`` keeps
that within a bound, ``joint_goal.py`` sees that a goal in joint coordinates is reached as it is
given, and ``cartesian_entry.py`` joins blends in space to lines in joint angles.
"""

from rfms_can.master.trajectory.planning.large_rotation import PartGoal
from rfms_can.master.trajectory.planning.limits import LimitedArm
from rfms_can.master.trajectory.planning.planner import MovePlanner, Plan, PlannedPosition
from rfms_can.master.trajectory.planning.straight_wrist import with_straight_wrist
from rfms_can.master.trajectory.planning.times import PlannedMode

__all__ = [
    "LimitedArm",
    "MovePlanner",
    "PartGoal",
    "Plan",
    "PlannedMode",
    "PlannedPosition",
    "with_straight_wrist",
]
