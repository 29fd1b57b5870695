"""Vectors of the detectors: a tachometer that is off, currents, heat, where a stop begins."""

from typing import Final

from generated import table

from node_book.pump import Pump, parameters
from rfms_can.joint_nodes.detectors.drive import AmplifierWatch, OverloadWatch
from rfms_can.joint_nodes.detectors.sensors import SensorWatch
from rfms_can.wire.vocabulary import Parameter

P = Parameter

SPEEDS: Final = (0, -80, -200, -240, -260, -260, -220, -280, -240, -240)
"""velocity_adc of a joint whose encoder goes two counts back in each cycle."""
COUNTS: Final = -2
DACS: Final = ((-200, 0), (-210, 0), (-190, 40), (-205, 0), (-200, 0))
CURRENTS: Final = (-203, -91, -90, -302, -303, -2048)
TORQUES: Final = (9.0, 9.0, 5.0, 7.0, 0.0)


def tachometer() -> str:
    """The two sums of a tachometer that shows too much, until one is beyond its bound."""
    p = parameters()
    watch, before, rows = SensorWatch(p), 0.0, []
    moved = COUNTS / p[P.COUNTS_PER_UNIT]
    for cycle, code in enumerate(SPEEDS, 1):
        speed = code * p[P.RATE_PER_CODE]
        trips = watch.differ(moved, speed, before)
        off = moved / p[P.PERIOD] - 0.5 * (speed + before)
        before = speed
        told = (str(cycle), str(COUNTS * cycle), str(code), f"{off:.6f}")
        sums = (f"{watch._up:.9f}", f"{watch._down:.9f}")
        rows.append((*told, *sums, "trips" if trips else ""))
        if trips:
            break
    columns = ("cycle", "counts", "velocity_adc", "d / tau, rad/s", "up, rad", "down, rad", "")
    return table(columns, rows)


def currents() -> str:
    """Currents against five DACs."""
    watch, rows = AmplifierWatch(parameters()), []
    for current, force in DACS:
        watch.drive(current, force)
    for code in CURRENTS:
        border = watch.border(code)
        rows.append((str(code), "" if border is None else f"{border:.3f}"))
    return table(("current_adc", "border it passed"), rows)


def heat() -> str:
    """Heat of torques, cycle by cycle."""
    watch, rows = OverloadWatch(parameters()), []
    for torque in TORQUES:
        watch.bears(torque)
        rows.append((f"{torque:g}", f"{watch.heat:.9f}"))
    return table(("torque, Nm", "heat, N2 m2 s"), rows) + f"\n\nIts bound is {watch.bound:.6f}."


BEGINS: Final = (
    (0.5, 0.4, 0.5, 0.3),
    (0.5, 0.2, 0.499, 0.3),
    (0.5, 0.2, 0.45, 0.3),
    (0.5, 0.2, 0.5, -0.3),
    (0.5, -2.2, 0.51, -2.4),
    (0.5, 0.0, 0.502, 0.1),
)
"""Commanded angle and rate, measured angle and speed."""


def begins() -> str:
    """Where a controlled stop begins."""
    controller, rows = Pump().started().node.controller, []
    assert controller is not None
    for at, rate, theta, speed in BEGINS:
        controller.sensing.theta, controller.sensing.speed = theta, speed
        controller._begin_stop(at, rate)
        ramp = controller.ramp
        assert ramp is not None
        rows.append(tuple(f"{x:.6f}" for x in (at, rate, theta, speed, ramp.position, ramp.speed)))
    return table(("p", "w", "θ", "v", "position", "speed"), rows)
