"""One trial: a fault in a warm system, watched for its cycles; in a fork, or in this process."""

import os
import random
import sys
import traceback
from collections.abc import Iterable, Iterator, Sequence
from typing import Final, NamedTuple, NoReturn

import msgspec

from rfms_can.errors import FaultError, RfmsError
from rfms_can.faults.catalogue import inject
from rfms_can.faults.context import Context
from rfms_can.faults.facts import Facts
from rfms_can.faults.forge import Forge
from rfms_can.faults.judge import detection, names_culprit, problems, reaction_of
from rfms_can.faults.site import Site
from rfms_can.faults.table import GOES_ON, State, Variant, variant_of
from rfms_can.faults.warm import FAR, LAST_CYCLE, MODE, WarmSystem
from rfms_can.faults.watch import Watch
from rfms_can.wire.nodes import JOINTS

WATCHED: Final = {True: 100, False: 300}
"""Cycles that a trial is watched: where the motion has to go on, and where it has to end."""
WATCHED_AT_WRIST: Final = 900
"""Cycles that an arm is watched which stands before a straight wrist: the way past it is slow."""
WATCHED_AT_LEAST: Final = 120
"""Cycles that an arm is watched which has come to rest: four times the longest bound, and past what
hung and wakes."""


def drawn_by(words: str) -> random.Random:
    """Random numbers that words stand for, the same on every machine."""
    return random.Random(words)


class Trial(NamedTuple):
    """A trial that can be made.

    Attributes:
        row: number of the fault.
        variant: name of the variant.
        arm: name of the arm.
        seed: draws the joint at fault, the cycle, and what the injector draws.
    """

    row: int
    variant: str
    arm: str
    seed: int

    @property
    def the_variant(self) -> Variant:
        """From the table.

        Raises:
            RfmsError: the row has no such variant.
        """
        variant = variant_of(self.row, self.variant)
        if variant is None:
            raise RfmsError(f"row {self.row} has no variant {self.variant!r}; see rfms faults")
        return variant

    @property
    def draw(self) -> random.Random:
        """New random numbers of the trial."""
        return drawn_by(f"{self.row}:{self.variant}:{self.arm}:{self.seed}")

    @property
    def cycle(self) -> int:
        """Of the strokes, from which on the fault is put in."""
        return self.draw.randint(0, LAST_CYCLE)

    @property
    def words(self) -> str:
        """As ``rfms faults --replay`` takes it."""
        return f"{self.row}:{self.variant}:{self.seed}"


class Result(msgspec.Struct, frozen=True):
    """What came of a trial.

    Attributes:
        row, variant, arm, seed: of the trial.
        met: whether it met its row.
        problems: what it did not meet.
        found: cycles until the fault was found, from its first effect; None if it was not.
        reaction: what came of it.
        culprit_ok: whether the right one was named.
        facts: what was measured; None if the trial broke off.
    """

    row: int
    variant: str
    arm: str
    seed: int
    met: bool
    problems: list[str]
    found: float | None = None
    reaction: str = ""
    culprit_ok: bool = False
    facts: Facts | None = None


def result_of(trial: Trial, facts: Facts) -> Result:
    """The judgement of a trial."""
    variant = trial.the_variant
    wrong = problems(variant, facts)
    return Result(
        *trial,
        not wrong,
        wrong,
        detection(variant, facts),
        reaction_of(variant, facts),
        names_culprit(variant, facts),
        facts,
    )


def site_of(trial: Trial, warm: WarmSystem) -> Site:
    """Where the fault of a trial is put in: at the joint that is drawn, or about its frames."""
    rig = warm.rig
    draw = trial.draw
    draw.randint(0, LAST_CYCLE)  # that is the cycle
    drawn = draw.choice(JOINTS)
    wire = rig.master.wire
    context = Context(
        arm=warm.arm,
        period_ns=rig.master.settings.period_ns,
        wire=wire,
        forge=Forge(wire),
        draw=draw,
        node=1 if warm.state in (State.NEAR_END, State.COMPLYING) else drawn,
        now_ns=lambda: rig.bus.now_ns,
        touch=lambda *_: None,
        friction=rig.master.settings.friction,
    )
    return Site(rig, context, warm.program, FAR, MODE)


def watch_trial(trial: Trial, warm: WarmSystem) -> Watch:
    """Put the fault in and watch what comes of it, in this process."""
    variant = trial.the_variant
    site = site_of(trial, warm)
    watch = Watch(site, variant)
    inject(variant.fault, site)
    if warm.state is State.START:
        try:
            warm.session.bring_up()
        except FaultError:
            watch.finish()
            return watch
    cycles = WATCHED[variant.expected in GOES_ON]
    if variant.state is State.AT_WRIST:
        cycles = WATCHED_AT_WRIST
    watch.run(cycles, WATCHED_AT_LEAST)
    return watch


def made_of(trials: Sequence[Trial]) -> Iterator[Result]:
    """Make trials of one arm and one state of the system: each in a fork of one warm system."""
    if not trials:
        return
    warm = WarmSystem(trials[0].arm, trials[0].the_variant.state)
    warm.begin()
    for trial in sorted(trials, key=lambda t: t.cycle):
        warm.run_to(trial.cycle)
        yield _in_a_fork(trial, warm)


def _in_a_fork(trial: Trial, warm: WarmSystem) -> Result:
    """The trial in a copy of this process, which stays as it is."""
    reader, writer = os.pipe()
    sys.stdout.flush()
    sys.stderr.flush()
    pid = os.fork()
    if pid == 0:
        os.close(reader)
        _child(trial, warm, writer)
    os.close(writer)
    with open(reader, "rb") as pipe:
        told = pipe.read()
    os.waitpid(pid, 0)
    if not told:
        return Result(*trial, False, ["the trial broke off without a word"])
    return msgspec.json.decode(told, type=Result)


def _child(trial: Trial, warm: WarmSystem, writer: int) -> NoReturn:
    """Make the trial and tell its result; whatever it raises is a trial that was not met.

    Nothing leaves this function, Ctrl-C included: two processes would go on as one campaign.
    """
    try:
        try:
            result = result_of(trial, watch_trial(trial, warm).facts())
        except Exception as error:
            why = f"the trial broke off: {type(error).__name__}: {error}"
            result = Result(*trial, False, [why])
            traceback.print_exc()
        with open(writer, "wb") as pipe:
            pipe.write(msgspec.json.encode(result))
    finally:
        os._exit(0)


def groups(trials: Iterable[Trial]) -> list[list[Trial]]:
    """Trials by arm and state of the system, so that each group has one warm system."""
    grouped: dict[tuple[str, State], list[Trial]] = {}
    for trial in trials:
        grouped.setdefault((trial.arm, trial.the_variant.state), []).append(trial)
    return list(grouped.values())
