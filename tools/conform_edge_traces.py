"""Inputs of the traces that meet the ends of the law: limits, dead bands, codes, 0 as a value."""

from typing import Final

from conform_law_traces import (
    BARE,
    COMPLYING,
    MIRRORED,
    NO_FRICTION,
    WEIGHTED,
    Cycle,
    Trace,
    held,
    loads,
    random_trace,
    trace,
)

EXACT: Final = {"PERIOD": 2.0**-8, "COUNTS_PER_UNIT": 8192.0}
AT: Final = 0.125
"""Where the joint of these traces stands, rad: whole counts of either encoder."""
CODE: Final = 0.006
"""TORQUE_PER_CODE of the bench, Nm."""
ONLY_I: Final = {**NO_FRICTION, "KP": 0.0, "KD": 0.0}


def traces() -> list[Trace]:
    """All of them."""
    return [*codes(), *limits(), *bands(), *zeros(), *ramps()]


def codes() -> list[Trace]:
    """The nearest code, of either DAC and either sign; the ends of its range."""
    parts = (0.0, 0.2, 0.45, 0.55, 0.8, 1.45, 1.55, 100.3, 100.7)
    torques = [sign * part * CODE for part in parts for sign in (1.0, -1.0)]
    forces = [sign * part * 0.004 for part in parts for sign in (1.0, -1.0)]
    ends = (2046.3, 2046.7, 2047.3, 2047.8, 2048.7, 2100.0)
    cut = [sign * end * 0.004 for end in ends for sign in (1.0, -1.0)]
    gravity = [{"rows": {"gravity": torque}} for torque in torques]
    strong = [{"rows": {"gravity": torque}} for torque in cut]
    bias = [{"bias": force} for force in forces] + [{"bias": force} for force in cut]
    fine = {**BARE, "TORQUE_PER_CODE": 0.004, "TORQUE_LIMIT": 80.0}
    return [
        trace("the nearest code", gravity, BARE, begin=AT),
        trace("the nearest code, mirrored", gravity, {**BARE, **MIRRORED}, begin=AT),
        trace("codes cut", strong, fine, begin=AT),
        trace("codes cut, mirrored", strong, {**fine, "TORQUE_PER_CODE": -0.004}, begin=AT),
        trace("the nearest code of a bias", bias, BARE, begin=AT),
    ]


def off(error: float, cycles: int = 1) -> list[Cycle]:
    """The joint beside its set-point by an error, rad."""
    return held(cycles, measured=AT - error)


def limits() -> list[Trace]:
    """The torque limit, met to the bit, and passed by the integral alone."""
    small = {"TORQUE_LIMIT": 0.3, "INTEGRAL_LIMIT": 0.2, "CONTINUOUS_TORQUE": 0.1}
    share: Cycle = {"selection": 1, "specification": 1}
    unshared = {**share, "law_row": [0.5, 0.0, 0.0, 0.4, 0.0, 0.0]}
    shared = {**share, "law_row": [0.5, 0.6, -0.7, 0.4, 0.0, 0.0]}
    there = loads(10.0, -10.0, step=2.5, **unshared)
    others = [[0.01, 0.0, 0.0], [-0.01, 0.0, 0.0], [0.01, 0.0, 0.0], *[[0.0, 0.0, 0.0]] * 2]
    return [
        trace(
            "gravity that is the torque limit",
            [
                cycle
                for sign in (1.0, -1.0)
                for cycle in (
                    *loads(10.0 * sign, step=2.5),
                    *off(sign * 40 / 8192, 6),
                    *loads(10.0 * sign, step=2.5)[2:0:-1],
                    *held(2),
                    *loads(10.0 * sign, step=2.5)[1:],
                    *off(-sign * 40 / 8192, 6),
                    *loads(10.0 * sign, step=2.5)[2::-1],
                    {"rows": {}},
                    *off(0.0, 2),
                )
            ],
            {**EXACT, **ONLY_I},
            begin=AT,
        ),
        trace(
            "an integral that reaches the torque limit",
            [
                cycle
                for sign in (1.0, -1.0)
                for cycle in (
                    *loads(9.5 * sign, step=2.5),
                    *off(sign * 80 / 8192, 60),
                    *loads(9.5 * sign, step=2.5)[2::-1],
                    {"rows": {}},
                    *held(2),
                    *off(-sign * 80 / 8192, 60),
                    *off(0.0, 2),
                )
            ],
            {**EXACT, **ONLY_I},
            begin=AT,
        ),
        trace(
            "little torque",
            [
                *loads(0.2, 0.3, step=0.07),
                *[{"bias": bias} for bias in (0.05, 0.7, -0.05, -0.7, 0.05)],
                *loads(0.3, -0.2, -0.3, 0.05, step=0.07)[5:],
                *[{"bias": bias} for bias in (-0.05, -0.4, 0.4, None)],
            ],
            {**BARE, **small, "TORQUE_PER_CODE": 2e-4},
            begin=AT,
        ),
        trace(
            "integrals without a share at the limit",
            [
                {"others": others},
                *there[:4],
                *held(20),
                {"rows": {**shared, "gravity": 7.5}},
                *held(6),
                *there[4:],
                *held(20),
                {"rows": {**shared, "gravity": -7.5}},
                *held(6),
            ],
            {**ONLY_I, "KI": 40.0, "TORQUE_PER_CODE": 1e-3},
            begin=AT,
        ),
    ]


def bands() -> list[Trace]:
    """Errors in the dead bands, at their ends, and beyond."""
    edge = [c for n in (1, 2, 3, 2, -1, -2, -3, -2, 0) for c in off(n / 8192, 5)]
    comply: Cycle = {"selection": 1, "specification": 1, "law_row": [1.0, 0.5, 0.5, 0.5, 0.5, 0.5]}
    errors = (1e-4, 2.4e-4, 2.6e-4, 4.9e-4, -2.4e-4, -2.6e-4, -4.9e-4, 0.0)
    complying = [
        cycle
        for k in range(5)
        for error in errors
        for cycle in held(3, others=[[error * (i == k), 0.0, 0.0] for i in range(5)])
    ]
    return [
        trace(
            "the end of the dead band",
            edge,
            {**EXACT, **ONLY_I, "KI": 4000.0, "INTEGRAL_DEADBAND": 2.0**-12},
            begin=AT,
        ),
        trace(
            "no dead band",
            edge,
            {**EXACT, **ONLY_I, "KI": 4000.0, "INTEGRAL_DEADBAND": 0.0},
            begin=AT,
        ),
        trace(
            "the dead band of what complies",
            [{"rows": comply}, *complying, *off(2 / 8192, 4), *off(3 / 8192, 4)],
            {**EXACT, **ONLY_I, "KI": 20000.0, "TORQUE_PER_CODE": 1e-3},
            begin=AT,
        ),
    ]


def zeros() -> list[Trace]:
    """What is 0, rigid and complying, under either law."""
    rows = [{**COMPLYING, "law_row": [0.7, 0.2, -0.1, 0.05, -0.3, 0.15]}, WEIGHTED, {}]
    none = {
        "no integral": {"INTEGRAL_LIMIT": 0.0},
        "no gain of the integral": {"KI": 0.0},
        "no proportional gain": {"KP": 0.0},
        "no damping": {"KD": 0.0, "DAMPING_RATIO": 0.0},
        "no frequency": {"NATURAL_FREQUENCY": 0.0},
        "friction one way": {"COULOMB_NEGATIVE": 0.0, "FRICTION_SPEED": 0.0, "VISCOUS": 0.0},
        "friction the other way": {"COULOMB_POSITIVE": 0.0, "DITHER_FRACTION": 1.0},
    }
    still = {"angle": AT}
    idle = [{"rows": {"selection": 1, "specification": 1}}, *held(3), *off(0.004, 4)]
    found = [trace("complying, no integral", idle, {"INTEGRAL_LIMIT": 0.0}, begin=AT)]
    for seed, (name, changes) in enumerate(none.items(), 11):
        drawn = random_trace(name, seed, rows, **changes)
        cycles = [{**cycle, **still, "measured": _near(cycle)} for cycle in drawn["cycles"]]
        found.append({**drawn, "cycles": cycles, "begin": AT})
    return found


def _near(cycle: Cycle) -> float:
    """As far from the set-point as in the motion that was drawn."""
    away: float = cycle["measured"] - cycle["angle"]
    return AT + round(8000.0 * away) / 8000.0


def ramps() -> list[Trace]:
    """A change of friction that is a step of its ramp, to the bit, as the ramp may end."""
    strong = {**BARE, "TORQUE_LIMIT": 1000.0, "VISCOUS": 8.0, "RATE_PER_CODE": 2.0**-9}
    comply: Cycle = {"selection": 1, "specification": 0}
    found = []
    for before in (23, 24, 25, 26):
        for sign in (1.0, -1.0):
            cycles = [
                {"rows": comply},
                *held(before - 1),
                {"speed": 0.75 * sign},
                *held(3, speed=3.5 * sign),
            ]
            changes = {**strong, "TORQUE_PER_CODE": 0.5}
            name = f"a step of friction, {before} cycles after compliance began, {sign:+g}"
            found.append(trace(name, cycles, changes, begin=AT))
    return found
