"""What the thesis timed in 1986: one literal table, and a row of it beside a figure of today."""

from dataclasses import dataclass
from typing import Final, NamedTuple


class Figure(NamedTuple):
    """One figure of the thesis.

    Attributes:
        key: what measures it here: an entry of ``MEASURES``.
        operation: in words.
        section: of the thesis, where the figure stands.
        unit: ``s``, where less is better, or ``Hz``, where more is.
        value: the figure, corrected where it is misprinted, or the sum it stands for.
        printed: as the thesis has it.
        counted: what is timed here.
        at_most: the thesis gives its worst case only, and this case may have taken less.
    """

    key: str
    operation: str
    section: str
    unit: str
    value: float
    printed: str
    counted: str
    at_most: bool = False


_WORST: Final = "1.3 ms in the worst case, joints 2 and 6"
_SOLVED: Final = "the joint's angle from T6 and a branch, nearest turn, range"

FIGURES: Final = (
    Figure("t6", "T6 of T6 A = B C from the ring", "VI.4.7", "s", 5e-3, "5 ms",
           "A, B and C new each time: one inverse, two products, and the walk round the ring"),
    Figure("drive", "drive transform: p, ψ, θ, φ of D(1)", "VI.4.7", "s", 3.27e-3, "3.27 ms",
           "rotation axis, its two Euler angles and the angle about it"),
    Figure("drive_whole", "drive transform, whole", "VI.4.7", "s", 3.27e-3, "3.27 ms",
           "more than 1986: also D(1) = L⁻¹ B R⁻¹, and D(r) for one r"),
    Figure("inverse_1", "inverse solution, joint 1", "VI.4.7", "s", 1.3e-3, _WORST, _SOLVED, True),
    Figure("inverse_2", "inverse solution, joint 2", "VI.4.7", "s", 1.3e-3, _WORST, _SOLVED),
    Figure("inverse_3", "inverse solution, joint 3", "VI.4.7", "s", 1.3e-3, _WORST, _SOLVED, True),
    Figure("inverse_4", "inverse solution, joint 4", "VI.4.7", "s", 1.3e-3, _WORST, _SOLVED, True),
    Figure("inverse_5", "inverse solution, joint 5", "VI.4.7", "s", 1.3e-3, _WORST, _SOLVED, True),
    Figure("inverse_6", "inverse solution, joint 6", "VI.4.7", "s", 1.3e-3, _WORST, _SOLVED),
    Figure("torque", "torque step of one joint (6.3)", "VI.4.7", "s", 1.4e-3, "1.4 ms",
           "hybrid law while the arm complies: row times six errors, PID, six integrals, gravity, "
           "row of M times six accelerations, friction, clamp, DAC code"),
    Figure("joint", "one joint processor, a cycle", "VI.4.7", "s", 4e-3, "about 4 ms",
           "the dearest of six nodes in motion, median of its cycles: all of its frames received, "
           "checked and sent as well, and the safety ladder"),
    Figure("setpoint", "Cartesian set-point, START of a transition", "VI.4.7", "s", 8.27e-3,
           "5 ms and 3.27 ms", "the generator's tick in which a straight line takes over: T6 of "
           "T6 A = B C for both goals, drive transform, where the transition starts"),
    Figure("rccl", "set-point of all joints (RCCL on a VAX 11/780)", "V.5", "s", 14e-3, "14 ms",
           "median of the task corner: generator, six joints' solutions and blends, limits"),
    Figure("dynamics_full", "dynamics update: whole", "VI.4.5", "s", 21e-3, "roughly 21 ms",
           "J, all of M, gravity, by Pinocchio: 1986 had the simplified model only"),
    Figure("dynamics_simplified", "dynamics update: simplified", "VI.4.5", "s", 21e-3,
           "roughly 21 ms", "D_ii, D_23, gravity of (4.9) to (4.12), and J"),
    Figure("c_hybrid", "C_θ update: hybrid", "VI.4.5", "s", 14e-3, "about 14 ms",
           "C_θ of (5.10b), bounded near singularities, and M C_θ, from J and M"),
    Figure("c_stiffness", "C_θ update: stiffness", "VI.4.5", "s", 14e-3, "about 14 ms",
           "J^T K J of (5.6) over the gains, from J; 1986 is the hybrid law's"),
    Figure("c_free_joint", "C_θ update: free joint", "VI.4.5", "s", 14e-3, "about 14 ms",
           "the projector of the matched joints, from J and M; 1986 is the hybrid law's"),
    Figure("background", "update rate, dynamics and C_θ", "VI.4.5", "Hz", 1 / 35e-3,
           "about 30 Hz (21 and 14 ms)", "one after the other: J, M, gravity, C_θ, and the "
           "values of six frames; computation alone"),
    Figure("serial", "servo rate, serial", "VI.4.7", "Hz", 1 / 7.27e-3, "130 to 140 Hz",
           "one over master plus dearest joint; computation alone, the rows of each cycle with it"),
    Figure("pipelined", "servo rate, pipelined", "VI.4.7", "Hz", 250.0, "250 Hz",
           "one over the longer of the two; computation alone, each node a processor of its own"),
    Figure("bus", "servo rate over the bus", "VI.4.7", "Hz", 250.0, "250 Hz",
           "CAN FD 1/5 Mbit/s, full, with all stuff bits; a usual cycle, six rows in it: computed, "
           "not timed"),
    Figure("network", "network, ten messages of 36 bytes", "VI.2", "s", 0.288e-3,
           "0.228 ms (its own arithmetic gives 0.288)",
           "Unix sockets of the link: ten clients at once, until the server has all ten"),
    Figure("network_can", "the same on the field bus", "VI.2", "s", 0.288e-3,
           "0.228 ms (its own arithmetic gives 0.288)",
           "ten CAN FD frames of 48 bytes (36 is no payload length), 1/5 Mbit/s, all stuff bits: "
           "computed, not timed"),
)  # fmt: skip
"""Thesis sections 4.5 and 4.7 of Chapter VI, VI.2 and V.5, in their order."""


@dataclass(frozen=True, slots=True)
class Row:
    """A figure of the thesis beside ours; ``ratio`` is how many times better it is here."""

    figure: Figure
    here: float

    @property
    def ratio(self) -> float:
        """Faster, or more often a second."""
        value = self.figure.value
        return self.here / value if self.figure.unit == "Hz" else value / self.here
