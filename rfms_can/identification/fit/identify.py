"""From the data of all experiments to a calibration, in the order of Chapter IV."""

from collections.abc import Mapping, Sequence
from math import hypot
from typing import Final

import numpy as np

from rfms_can.analysis.cycles import Floats
from rfms_can.arm import JOINT_COUNT, Arm
from rfms_can.arm.torque_law import TorqueLaw
from rfms_can.dynamics.fitted import fitted_constants
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.dynamics.terms import COUPLING
from rfms_can.identification.experiments.data import Data
from rfms_can.identification.fit.constants import (
    gravity_fit,
    inertia_fits,
    pose_inertias,
)
from rfms_can.identification.fit.least_squares import Fit, IdentificationError
from rfms_can.identification.fit.links import LinkFit, Samples, fit_links, samples_of
from rfms_can.identification.fit.momentum import Motion, motions_of
from rfms_can.identification.fit.result import Identification
from rfms_can.identification.fit.static import breakaways
from rfms_can.identification.fit.torque import (
    KnownLoad,
    TorqueFit,
    fit_vertical_joint,
    fit_weight_loaded_joint,
)
from rfms_can.identification.fit.trace import Trace, converter_fits, trace_of
from rfms_can.identification.fit.windows import Window, windows_of

OFFSET_CODES: Final = 5.0
"""Largest difference of an ADC's offset from the others, codes, that is not reported."""
DRAWS: Final = 12
VALIDATION: Final = "tour-2"
"""The experiment excluded from all fits."""


def identify(arm: Arm, data: Mapping[str, Data]) -> Identification:
    """Analyse all experiments.

    Raises:
        IdentificationError: the data do not determine the parameters.
    """
    converters = converter_fits(arm, list(data.values()))
    traces = {name: trace_of(arm, each, converters) for name, each in data.items()}
    windows = [window for trace in traces.values() for window in windows_of(trace)]
    torque = _torques(arm, traces, windows)
    laws = [fit.law for fit in torque]
    _require_possible(laws)
    gravity = gravity_fit(windows, laws)
    bare = {name: trace for name, trace in traces.items() if not trace.load}
    motions = [motion for trace in bare.values() for motion in motions_of(trace)]
    period_s = next(iter(traces.values())).period_s
    poses = pose_inertias(motions, laws, gravity.values, period_s)
    inertia = inertia_fits(poses)
    both = {**gravity.values, **inertia.values}
    model = ArmDynamics(arm)
    samples = {name: samples_of(trace, arm, laws, model) for name, trace in bare.items()}
    links = fit_links(each for name, each in samples.items() if name != VALIDATION)
    return Identification(
        arm,
        converters,
        torque,
        [b for trace in bare.values() for b in breakaways(trace, laws, both, arm)],
        _widened(gravity, torque),
        poses,
        _widened(inertia, torque),
        links,
        _widened(_coupling(arm, links), torque),
        _validated(links, samples[VALIDATION]),
        [*_own_currents(converters, arm)],
    )


def _torques(arm: Arm, traces: Mapping[str, Trace], windows: Sequence[Window]) -> list[TorqueFit]:
    known = KnownLoad.of(arm)
    first = [window for window in windows if window.joint == 0]
    turning = _stretched(traces)
    period_s = next(iter(traces.values())).period_s
    fits = [fit_vertical_joint(first, turning, period_s, known, "torque of joint 1")]
    for joint in range(1, JOINT_COUNT):
        own = [window for window in windows if window.joint == joint]
        fits.append(fit_weight_loaded_joint(own, known, f"torque of joint {joint + 1}"))
    return fits


def _stretched(traces: Mapping[str, Trace]) -> list[Motion]:
    """Bursts of joint 1 at the pose used with and without the load."""
    loaded = [m for t in traces.values() if t.load for m in motions_of(t) if m.joint == 0]
    bare = [m for t in traces.values() if not t.load for m in motions_of(t) if m.joint == 0]
    if not loaded:
        raise IdentificationError("torque of joint 1: no motion with the known load")
    there = loaded[0].pose[1:]
    return [m for m in (*loaded, *bare) if np.abs(m.pose[1:] - there).max() < _SAME_POSE]


_SAME_POSE: Final = 0.03


def _require_possible(laws: Sequence[TorqueLaw]) -> None:
    """Refuse laws that are physically impossible.

    Raises:
        IdentificationError: names the joint and the value.
    """
    for joint, law in enumerate(laws, start=1):
        for name in ("slope_positive", "slope_negative"):
            if not getattr(law, name) > 0.0:
                raise IdentificationError(
                    f"joint {joint}: {name} comes out as {getattr(law, name):.4g} Nm a code: the "
                    f"known load was not in the hand when it should be, or has another weight"
                )


def _widened(constants: Fit, torque: Sequence[TorqueFit]) -> Fit:
    """The fit with deviations that include those of the slopes, with which a constant scales."""
    deviations = {}
    for name, own in constants.deviations.items():
        fit = torque[int(name[1]) - 1].fit
        slopes = ("slope_positive", "slope_negative")
        relative = max(fit.deviations[slope] / fit.values[slope] for slope in slopes)
        deviations[name] = hypot(own, relative * constants.values[name])
    return constants._replace(deviations=deviations)


def _coupling(arm: Arm, links: LinkFit) -> Fit:
    """D23's constants by the links, with the deviations that follow from the links' covariance."""
    values = _couplings(arm, links.parameters, links.armature)
    draw = np.random.default_rng(0)
    drawn = []
    for _ in range(DRAWS):
        parameters, armature = links.drawn(draw)
        drawn.append(list(_couplings(arm, parameters, armature).values()))
    spread = np.std(drawn, axis=0)
    deviations = dict(zip(values, spread.tolist(), strict=True))
    return Fit(values, deviations, float(links.residual[1]), int(links.equations[1]), 1.0)


def _couplings(arm: Arm, parameters: Floats, armature: Floats) -> dict[str, float]:
    found = fitted_constants(ArmDynamics(arm, parameters, armature.tolist()))
    return {name: found[name] for name in COUPLING}


def _validated(links: LinkFit, samples: Samples) -> Floats:
    whole = np.concatenate((links.parameters.ravel(), links.armature))
    residual = samples.torque - samples.regressor @ whole
    moving = samples.moving
    rms = [
        [
            float(np.sqrt(np.mean(values[moving[:, joint], joint] ** 2)))
            for joint in range(JOINT_COUNT)
        ]
        for values in (samples.torque, residual)
    ]
    return np.array(rms)


def _own_currents(converters: Sequence[Fit], arm: Arm) -> list[str]:
    """Amplifiers with a current offset: their ADC's offset differs from the others."""
    offsets = np.array([fit.values["offset"] for fit in converters])
    usual = float(np.median(offsets))
    notes = []
    for joint, fit in enumerate(converters):
        codes = (fit.values["offset"] - usual) / fit.values["slope"]
        if abs(offsets[joint] - usual) > OFFSET_CODES:
            notes.append(
                f"joint {joint + 1} of {arm.name}: a current offset of {codes:+.1f} DAC codes: its "
                f"ADC reads {offsets[joint]:.1f} at code 0, the others {usual:.1f}; its offsets "
                f"B_p and B_n include it"
            )
    return notes
