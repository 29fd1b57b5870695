"""The file of a campaign of random programs: its conditions, then a line for each program."""

from typing import Final, NamedTuple

from random_programs.trial import Result
from rfms_can.engine import ResultFile

KEPT: Final = "docs/data/program_campaign.jsonl"
"""The campaign that docs/random-programs.md tells of."""


KEPT_ON_THE_BUS: Final = "docs/data/program_bus_campaign.jsonl"
"""The same on the whole simulated bus."""


class Conditions(NamedTuple):
    """What all programs of a file have in common.

    Attributes:
        rate: set-points a second.
        mix: number of the way programs are drawn; another one draws others from the same seeds.
    """

    rate: float
    mix: int


class Brief(NamedTuple):
    """A program as it is kept: what the table needs, and the words of what went wrong only.

    Attributes:
        a: name of the arm.
        s: seed.
        n, ok: moves it has, and those accepted as they were asked for.
        why: kind of the first refusal, or "".
        fix: remedies taken.
        bad: what of the promise was broken, or "".
        v, acc: largest speed and acceleration over the joints' limits.
        c, lag: cycles run, and those in which a joint lagged behind its path.
    """

    a: str
    s: int
    n: int
    ok: int
    why: str
    fix: str
    bad: str
    v: float
    acc: float
    c: int
    lag: int

    @classmethod
    def of(cls, result: Result) -> "Brief":
        """A result, shortened."""
        fix = " ".join(sorted(result.remedies))
        return cls(
            *(result.arm, result.seed, result.moves, result.accepted, result.kind, fix),
            *(result.broken, round(result.speed, 4), round(result.acceleration, 4)),
            *(result.cycles, result.lagged),
        )


FILE: Final = ResultFile("programs", "tools/program_campaign.py", Conditions, Brief)
read = FILE.read
