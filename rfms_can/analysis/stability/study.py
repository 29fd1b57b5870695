"""One question about stability: an arm, a law, gains, a selection and a compliance frame."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.analysis.stability.continuous import Poles, Verdict, growth, poles, verdict
from rfms_can.analysis.stability.loop import Loop, pid_loop, scheduled_loop, weighted_loop
from rfms_can.analysis.stability.sampled import gain_margin, is_stable, sampled_poles
from rfms_can.arm import Arm, friction_set
from rfms_can.compliance import (
    LAWS,
    ControlLaw,
    LawRows,
    RowsAtPose,
    Selection,
    Servos,
    compliance_jacobian,
    conflicts,
    regular_pose,
)
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.errors import RfmsError
from rfms_can.master.start_up.node_parameters import DAMPING_RATIO, joint_parameters
from rfms_can.tables import complete
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Law, Parameter

Matrix = npt.NDArray[np.float64]

_SLOWEST, _FASTEST = 1e-2, 1e4
"""Natural frequencies there may be, rad/s."""
_NONE: Final = Selection()
_AT_T6: Final = Transform.identity()


@dataclass(frozen=True, slots=True)
class Study:
    """What is asked.

    Attributes:
        arm: the arm.
        selection: what complies.
        frame: pose of the compliance frame in T6.
        law: the law.
        natural: wn of the six joints, rad/s; empty: that of the nodes at this rate. Gains are
            d_ii wn^2 and 2 zeta d_ii wn with the inertia at the park pose, as the nodes have them.
        damping_ratio: zeta.
        rate_hz: control rate.
        compliant_rate: damping of the compliant directions, 1/s: M (I - C) times it, with PID
            d_ii (I - C).
        friction: friction set whose viscous part brakes the plant.
        diagonal: the thesis' plant (5.12): inertia d_ii of the park pose, everywhere, no coupling.
        scheduled: A of Maples and Goldman's velocity gains (5.13), in place of the law's own;
            2 zeta sqrt(d) damps a joint of inertia d with zeta. 0: the law's own.
        payload: mass at the origin of the compliance frame, kg, that the plant carries and the
            rows do not know of.
    """

    arm: Arm
    selection: Selection = _NONE
    frame: Transform = _AT_T6
    law: ControlLaw = ControlLaw.HYBRID
    natural: tuple[float, ...] = ()
    damping_ratio: float = DAMPING_RATIO
    rate_hz: float = 250.0
    compliant_rate: float = 0.0
    friction: str = "none"
    diagonal: bool = False
    scheduled: float = 0.0
    payload: float = 0.0

    def __post_init__(self) -> None:
        friction_set(self.arm, self.friction)
        if self.natural and (
            len(self.natural) != 6 or not all(_SLOWEST <= wn <= _FASTEST for wn in self.natural)
        ):
            raise RfmsError(
                f"natural frequencies {self.natural}: give six, {_SLOWEST:g} to {_FASTEST:g} rad/s"
            )
        for name, value, low, high in (
            ("damping ratio", self.damping_ratio, 1e-3, 100.0),
            ("rate", self.rate_hz, 1.0, 1e5),
            ("compliant damping", self.compliant_rate, 0.0, _FASTEST),
            ("A of the scheduled gains", self.scheduled, 0.0, _FASTEST),
            ("payload", self.payload, 0.0, 1e3),
        ):
            if not low <= value <= high:
                raise RfmsError(f"{name} {value:g} is not in {low:g}..{high:g}")
        if _TORQUES[LAWS[self.law].wire].one_frequency and len(set(self.natural)) > 1:
            raise RfmsError(
                f"law {self.law.value} has one natural frequency for all joints, not {self.natural}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Analysis:
    """The answer at one pose.

    Attributes:
        q: joint angles, rad.
        poles: twelve, 1/s.
        verdict: what they say.
        growth: largest real part, 1/s.
        sampled: eighteen poles of the loop on the bus, per period.
        sampled_stable: whether that loop is stable, or drifts.
        margin: how many times faster the servo could be before the sampled loop is unstable; None
            if it was not asked for.
        conflicts: directions that cannot be had apart here.
    """

    q: tuple[float, ...]
    poles: Poles
    verdict: Verdict
    growth: float
    sampled: Poles
    sampled_stable: bool
    margin: float | None
    conflicts: tuple[str, ...]

    @property
    def on_the_bus(self) -> Verdict:
        """What the sampled poles say; the loop drifts where the continuous one does."""
        if not self.sampled_stable:
            return Verdict.UNSTABLE
        return Verdict.DRIFTS if self.verdict is Verdict.DRIFTS else Verdict.STABLE


class Analyst:
    """Answers a study pose by pose; keeps the arm's model between them."""

    def __init__(self, study: Study) -> None:
        self.study = study
        arm = study.arm
        self._dynamics = ArmDynamics(arm)
        nodes = joint_parameters(arm, study.friction, 1.0 / study.rate_hz)
        own = [nodes[n][Parameter.NATURAL_FREQUENCY] for n in sorted(nodes)]
        self.natural = np.array(study.natural or own)
        self.inertia = np.diag(self._dynamics.inertia_matrix(arm.park)).copy()
        self.Kp = self.inertia * self.natural**2
        self.Kd = 2.0 * study.damping_ratio * self.inertia * self.natural
        self._friction = [joint.viscous for joint in friction_set(arm, study.friction)]
        self._law = LAWS[study.law]
        self._servos = Servos(list(self.Kp), float(self.natural[0]), arm.a2)
        self._begun = self._begin(*self._model(arm.park))

    def analyse(self, q: Sequence[float], *, margin: bool = False) -> Analysis:
        """Poles and verdicts at six joint angles, rad; the gain margin (slow) if asked for."""
        J, M = self._model(q)
        rows = self._rows(J, M)
        loop, period = self._loop(rows, J, M), 1.0 / self.study.rate_hz
        values, sampled = poles(loop), sampled_poles(loop, period)
        named: tuple[str, ...] = ()
        if rows.projection is not None and self._law.parts_directions:
            found = conflicts(rows.projection, J, self.study.selection)
            named = tuple(str(conflict) for conflict in found)
        return Analysis(
            tuple(q),
            values,
            verdict(loop, values),
            growth(values),
            sampled,
            is_stable(sampled),
            gain_margin(loop, period) if margin else None,
            named,
        )

    def loop(self, q: Sequence[float]) -> Loop:
        """The linear loop at six joint angles, rad."""
        J, M = self._model(q)
        return self._loop(self._rows(J, M), J, M)

    def _model(self, q: Sequence[float]) -> tuple[Matrix, Matrix]:
        dynamics = self._dynamics
        dynamics.update(regular_pose(self.study.arm, q))
        J = compliance_jacobian(dynamics.J, self.study.frame)
        return J, np.diag(self.inertia) if self.study.diagonal else dynamics.M

    def _begin(self, J: Matrix, M: Matrix) -> RowsAtPose:
        return self._law.begin(J, M, self.study.selection, self._servos)

    def _rows(self, J: Matrix, M: Matrix) -> LawRows:
        begun = self._begin(J, M) if self._law.begins_at_each_pose else self._begun
        return begun(J, M)

    def _loop(self, rows: LawRows, J: Matrix, M: Matrix) -> Loop:
        plant = M + self.study.payload * J[:3].T @ J[:3]
        loop = _TORQUES[self._law.wire].loop(self, plant, M, rows.errors)
        if self.study.scheduled:
            loop = scheduled_loop(loop, self.study.scheduled)
        return loop

    def _pid_loop(self, plant: Matrix, M: Matrix, C: Matrix) -> Loop:
        rate = self.study.compliant_rate if self._law.damped else 0.0
        return pid_loop(
            plant,
            C,
            list(self.Kp),
            list(self.Kd),
            self._free,
            compliant_damping=list(rate * self.inertia),
            friction=self._friction,
        )

    def _weighted_loop(self, plant: Matrix, M: Matrix, C: Matrix) -> Loop:
        return weighted_loop(
            plant,
            M,
            C,
            float(self.natural[0]),
            self.study.damping_ratio,
            self._free,
            compliant_rate=self.study.compliant_rate,
            friction=self._friction,
        )

    @property
    def _free(self) -> int:
        return self.study.selection.size if self._law.complies else 0


class _Torque(NamedTuple):
    """A torque equation of the nodes, as the analysis has it.

    Attributes:
        loop: the linear loop of an analyst's nodes, from the plant's inertia, M of the rows, and C.
        one_frequency: whether all joints have the same natural frequency.
    """

    loop: Callable[[Analyst, Matrix, Matrix, Matrix], Loop]
    one_frequency: bool


_TORQUES: Final = complete(
    {
        Law.PID: _Torque(Analyst._pid_loop, one_frequency=False),
        Law.WEIGHTED: _Torque(Analyst._weighted_loop, one_frequency=True),
    },
    Law,
)
