"""Stability of force control (thesis V.6): closed-loop poles, continuous and as the bus runs it."""

from rfms_can.analysis.stability.continuous import Verdict, growth, poles, state_matrix, verdict
from rfms_can.analysis.stability.loop import Loop, pid_loop, scheduled_loop, weighted_loop
from rfms_can.analysis.stability.sampled import (
    gain_margin,
    is_stable,
    largest_frequency,
    sampled_matrix,
    sampled_poles,
)
from rfms_can.analysis.stability.study import Analysis, Analyst, Study
from rfms_can.analysis.stability.survey import (
    Grid,
    Survey,
    grid_poses,
    parse_pose,
    path_poses,
    random_poses,
    survey,
)
from rfms_can.compliance import ControlLaw

__all__ = [
    "Analysis",
    "Analyst",
    "ControlLaw",
    "Grid",
    "Loop",
    "Study",
    "Survey",
    "Verdict",
    "gain_margin",
    "grid_poses",
    "growth",
    "is_stable",
    "largest_frequency",
    "parse_pose",
    "path_poses",
    "pid_loop",
    "poles",
    "random_poses",
    "sampled_matrix",
    "sampled_poles",
    "scheduled_loop",
    "state_matrix",
    "survey",
    "verdict",
    "weighted_loop",
]
