"""References campaign: what an arm would follow when a camera looks at an object, and falls silent.

    python tools/reference_campaign.py --keep references.jsonl --seeds 200

Each run is a reference of the world model alone, without an arm: an object that moves in a known
way, a camera with a rate, a latency, noise, jitter, losses and outliers, and silence from some time
on. Its numbers are distances, m, of the reference from the object, at the ticks of the arm:

- ``tracked_rms``, ``tracked_max``: while it is seen, from half a second after the first time on;
- ``seen_max``: from the fourth observation on, while it is seen;
- ``silent_max``: from the last observation on, for two seconds (of an object that stands still);
- ``rest_s``: from the last observation until the reference rests.

A line of the file is one run with its settings; runs that are in the file are not made again, so
that a campaign that was interrupted goes on where it was. The table at the end has one row for each
condition, over its seeds.
"""

import math
import random
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Final, NamedTuple

from campaign_options import backend, campaign_parser, exit_with

from rfms_can import engine
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import Goal, Moment
from rfms_can.master.world import Limits, WorldModel
from rfms_can.messages import T6, PositionMessage, TransformMessage
from rfms_can.transform import Transform

PERIOD_S: Final = 0.004
LATENCY_S: Final = 0.02
LATENCY_JITTER_S: Final = 0.01
SETTLED_S: Final = 0.5
SILENT_S: Final = 2.0
OUTLIER_M: Final = 1.0
LIMITS: Final = Limits(1.0, 5.0)

RATES_HZ: Final = (25, 50, 100, 250, 500)


class Conditions(NamedTuple):
    """Of a run.

    Attributes:
        motion: of the object, one of ``MOTIONS``.
        rate: of the camera, Hz.
        noise: of an observation in each direction, standard deviation, m.
        jitter: of the times of pictures, part of the interval.
        loss: part of the pictures that is lost.
        outliers: part of the pictures that show something else, up to a metre away.
        limited: whether the arm moves with the reference, within the acceleration of a mode.
        seed: of all that is random.
    """

    motion: str
    rate: int
    noise: float
    jitter: float
    loss: float
    outliers: float
    limited: bool
    seed: int


Path3 = Callable[[float], tuple[float, float, float]]


def _speeding(time: float) -> tuple[float, float, float]:
    """From rest at 1 m/s2 to 0.2 m/s, and back to rest after 1.5 s."""
    ramp = 0.2

    def way(begun: float) -> float:
        t = max(0.0, begun)
        return 0.5 * t * t if t < ramp else ramp * (t - 0.5 * ramp)

    return (0.3, way(time - 0.7) - way(time - 1.5), 0.0)


MOTIONS: Final[dict[str, Path3]] = {
    "still": lambda _: (0.3, 0.0, 0.0),
    "belt": lambda t: (0.3, 0.1 * t, 0.0),
    "fast belt": lambda t: (0.3, 0.3 * t, 0.0),
    "swinging": lambda t: (0.3, 0.05 * math.sin(math.pi * t), 0.0),
    "speeding": _speeding,
    "jumping": lambda t: (0.3 if t < 1.2 else 0.37, 0.0, 0.0),
}


class Picture(NamedTuple):
    """When it was taken and when it arrives, s, and what it shows."""

    arrives: float
    taken: float
    pose: Transform


class Numbers(NamedTuple):
    """See the head of this file."""

    tracked_rms: float | None
    tracked_max: float | None
    seen_max: float
    silent_max: float | None
    rest_s: float


class Run(NamedTuple):
    """A line of the file."""

    conditions: Conditions
    numbers: Numbers


KEPT: Final = "references.jsonl"
FILE: Final = engine.ResultFile[None, Run](
    "runs", "tools/reference_campaign.py", None, Run, digits=4
)


def pictures(conditions: Conditions, until: float) -> list[Picture]:
    """All that the camera sends, by the time it arrives."""
    chance = random.Random(repr(conditions))
    where, interval = MOTIONS[conditions.motion], 1.0 / conditions.rate
    found = []
    for k in range(math.ceil(until / interval)):
        taken = max(0.0, (k + conditions.jitter * chance.uniform(-0.5, 0.5)) * interval)
        point = [x + chance.gauss(0.0, conditions.noise) for x in where(taken)]
        if chance.random() < conditions.outliers:
            point = [x + chance.uniform(-OUTLIER_M, OUTLIER_M) for x in point]
        if chance.random() >= conditions.loss:
            arrives = taken + LATENCY_S + chance.uniform(0.0, LATENCY_JITTER_S)
            found.append(Picture(arrives, taken, Transform.translation(*point)))
    return sorted(picture for picture in found if picture.arrives < until)


def run(conditions: Conditions) -> Numbers:
    """One run."""
    silent_from = random.Random(f"silence {conditions!r}").uniform(0.15, 3.0)
    if conditions.motion != "still":
        silent_from = max(2.0, silent_from)
    where = MOTIONS[conditions.motion]
    world = WorldModel(Configuration(True, True, True), PERIOD_S)
    start = Transform.translation(*where(0.0))
    world.define_transform(TransformMessage("part", start, "reference", predict="velocity"))
    goal: Goal = world.define_position(PositionMessage("at part", [T6], ["part"])).goal
    waiting = iter(pictures(conditions, silent_from))
    upcoming, seen, last_s, rests_from = next(waiting, None), 0, 0.0, 0.0
    limits = LIMITS if conditions.limited else None
    tracked, seen_max, silent_max = [], 0.0, 0.0
    before = goal.pose(Moment(0))
    for tick in range(1, round((silent_from + SILENT_S) / PERIOD_S)):
        now = tick * PERIOD_S
        while upcoming is not None and upcoming.arrives <= now:
            message = TransformMessage("part", upcoming.pose, "reference", stamp=upcoming.taken)
            world.define_transform(message, tick, limits)
            upcoming, seen, last_s = next(waiting, None), seen + 1, now
        for name in world.silent(tick):
            world.settle_transform(name, tick, limits)
        pose = goal.pose(Moment(tick))
        error = math.dist((pose.px, pose.py, pose.pz), where(now))
        if now < silent_from:
            seen_max = max(seen_max, error) if seen > 3 else seen_max
            if now > SETTLED_S:
                tracked.append(error)
        else:
            silent_max = max(silent_max, error) if seen > 3 else silent_max
        if pose != before:
            rests_from = now
        before = pose
    return Numbers(
        math.sqrt(sum(e * e for e in tracked) / len(tracked)) if tracked else None,
        max(tracked, default=None),
        seen_max,
        silent_max if conditions.motion == "still" else None,
        max(0.0, rests_from - last_s),
    )


def grid(seeds: int) -> Iterator[Conditions]:
    """All runs of a campaign."""
    disturbed = ((0.0, 0.0, 0.0), (0.6, 0.3, 0.0), (0.6, 0.3, 0.05))
    for seed, motion, rate, noise, (jitter, loss, outliers), limited in product(
        range(seeds), MOTIONS, RATES_HZ, (0.2e-3, 0.5e-3), disturbed, (False, True)
    ):
        yield Conditions(motion, rate, noise, jitter, loss, outliers, limited, seed)


def observed(conditions: Conditions) -> Run:
    """A run, for the file."""
    return Run(conditions, run(conditions))


def table(runs: Mapping[Conditions, Numbers]) -> Iterator[str]:
    """One row for each condition: the rms and the largest value of each number, mm and s."""
    rows: dict[Conditions, list[Numbers]] = defaultdict(list)
    for conditions, numbers in runs.items():
        rows[conditions._replace(seed=0)].append(numbers)
    yield (
        f"{'motion':<10}{'rate':>5}{'noise':>6}{'jitter':>7}{'loss':>5}{'outl':>6}{'limits':>7}"
        f"{'runs':>6}{'rms':>8}{'max':>8}{'seen':>8}{'silent':>8}{'rest':>7}"
    )
    for c, found in sorted(rows.items()):
        worst = (
            _largest([numbers[i] for numbers in found], 1.0 if i == 4 else 1e3) for i in range(5)
        )
        rms, largest, seen, silent, rest = worst
        yield (
            f"{c.motion:<10}{c.rate:>5}{1e3 * c.noise:>6.1f}{c.jitter:>7.1f}{c.loss:>5.1f}"
            f"{c.outliers:>6.2f}{'yes' if c.limited else 'no':>7}{len(found):>6}"
            f"{rms:>8}{largest:>8}{seen:>8}{silent:>8}{rest:>7}"
        )


def _largest(values: list[float | None], factor: float) -> str:
    present = [value for value in values if value is not None]
    return f"{factor * max(present):.2f}" if present else "-"


def main() -> int:
    """Make the runs that are missing and print the table."""
    parser = campaign_parser(__doc__, KEPT)
    parser.set_defaults(keep=Path(KEPT))
    parser.add_argument("--seeds", type=int, default=20, help="runs for each condition")
    parser.add_argument("--motion", choices=tuple(MOTIONS), help="of this motion only")
    options = parser.parse_args()
    workers = backend(options)
    kept = FILE.open(options.keep, None)
    engine.carry_out(
        [each for each in grid(options.seeds) if options.motion in (None, each.motion)],
        lambda left: engine.run(observed, left, workers),
        kept,
        what="runs",
        job_key=lambda conditions: conditions,
        result_key=lambda result: result.conditions,
    )
    print("\n".join(table({each.conditions: each.numbers for each in kept.results})))
    return 0


if __name__ == "__main__":
    exit_with(main)
