"""One trial with processes: a system is started, a fault put in, and what comes of it judged."""

import contextlib
import re
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any, Final

from rfms_can.arm import arm_by_name
from rfms_can.errors import RfmsError
from rfms_can.faults.facts import Facts
from rfms_can.faults.processes.command import Main
from rfms_can.faults.processes.effect import Scene, effect_ns
from rfms_can.faults.processes.evidence import Evidence
from rfms_can.faults.processes.injectors import PROCESS_INJECTORS, ProcessInjector
from rfms_can.faults.processes.strokes import LONG
from rfms_can.faults.processes.system import END_S, NotReadyError, System
from rfms_can.faults.table import BUS, GOES_ON, Variant
from rfms_can.faults.trial import Result, Trial, result_of
from rfms_can.faults.warm import STROKES
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.rig.candump import CandumpWriter
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS, NODE_NAMES, SIMULATED

WATCHED: Final = 20
"""Cycles that a stop is watched: without SYNC the plant takes one for each period of a stop."""
BEYOND: Final = 12
"""Cycles that are watched beyond the bound: brakes close and joints come to rest in them."""
BACK: Final = 10
"""Cycles that are watched at least, once a fault is put in whole: what comes back might drive."""
BEFORE: Final = 4000
"""Frames before the fault that are looked at: heartbeats of all nodes are among them."""
ATTEMPTS: Final = 3
"""Systems that are started for a trial, where a busy machine does not let the arm be seen move."""
BUS_LOG: Final = "bus.log"
_NAMES: Final = re.compile("|".join(NODE_NAMES[n] for n in SIMULATED))
_GONE: Final = re.compile(r"has gone|Network is down")


def made(trial: Trial, bus: str, main: Main, keep: Path | None = None) -> Result:
    """Make a trial; whatever it raises is one that was not met.

    A system in which no fault could be put in is started again, ``ATTEMPTS`` times in all.

    Args:
        trial: which.
        bus: URL of its bus; a hub of that name must not run.
        main: the command line.
        keep: directory for what the commands print and for the bus; made if it does not exist.
    """
    with tempfile.TemporaryDirectory(prefix="rfms-fault-") as temporary:
        directory = Path(temporary)
        if keep is not None:
            keep.mkdir(parents=True, exist_ok=True)
            directory = keep
        try:
            return result_of(trial, _tried(trial, bus, main, directory, keep is not None))
        except Exception as error:
            if not isinstance(error, RfmsError):
                traceback.print_exc()
            why = f"the trial broke off: {type(error).__name__}: {error}"
            return Result(*trial, False, [why])


def _tried(trial: Trial, bus: str, main: Main, directory: Path, kept: bool) -> Facts:
    """The facts of the first system in which the fault could be put in."""
    for _ in range(ATTEMPTS - 1):
        with contextlib.suppress(NotReadyError):
            return _facts(trial, bus, main, directory, kept)
    return _facts(trial, bus, main, directory, kept)


def _facts(trial: Trial, bus: str, main: Main, directory: Path, kept: bool) -> Facts:
    variant = trial.the_variant
    injector = PROCESS_INJECTORS[variant.fault]
    draw = trial.draw
    cycle, joint = trial.cycle, _drawn(trial)
    on_hub = bus.startswith("hub:")
    system = System(
        *(main, bus, trial.arm, directory, joint),
        seam=None if injector.seam is None else injector.seam(draw, on_hub),
        strokes=STROKES if variant.expected in GOES_ON else LONG,
        recorded=injector.recorded,
    )
    try:
        system.run_to(cycle)
        begun = len(system.tape.frames)
        at_ns = time.monotonic_ns()
        injector.make(system)
        over_ns = _watch(system, variant, at_ns)
        left = [str(pid) for pid in system.finish()]
        scene = _scene(system, begun, at_ns)
        return _seen(system, variant, injector, scene, over_ns, left)
    finally:
        if kept:
            _write(system, directory / BUS_LOG)
        system.close()


def _drawn(trial: Trial) -> int:
    """The joint at fault."""
    draw = trial.draw
    draw.random()
    return draw.choice(JOINTS)


def _watch(system: System, variant: Variant, at_ns: int) -> int | None:
    """Let it happen: to the program's end where the motion has to go on.

    Returns:
        When all processes had ended; None if they had not.
    """
    if variant.expected in GOES_ON:
        system.tape.listen(END_S, lambda: not system.up.alive)
        return None
    so_far = (time.monotonic_ns() - at_ns) * 1e-9 / system.barrier_s
    wanted = max(WATCHED, variant.bound + BEYOND)
    left = max(wanted - so_far, BACK) * system.barrier_s
    over = variant.culprit == BUS and system.tape.listen(left, lambda: not system.running)
    if variant.culprit != BUS:
        system.tape.listen(left)
    return time.monotonic_ns() if over else None


def _scene(system: System, begun: int, at_ns: int) -> Scene:
    tape = system.tape
    before = list(tape.heard(max(0, begun - BEFORE), begun))
    return Scene(before, list(tape.heard(begun)), at_ns)


def _seen(
    system: System,
    variant: Variant,
    injector: ProcessInjector,
    scene: Scene,
    over_ns: int | None,
    left: list[str],
) -> Facts:
    """The facts, by the tape and by how the commands ended."""
    node = injector.node or system.joint
    cycle_ns = round(system.barrier_s * 1e9)
    shown_ns = effect_ns(injector.shows, scene, node, cycle_ns)
    begun_ns = scene.at_ns if shown_ns is None else shown_ns
    evidence = Evidence(
        *(Wire(), arm_by_name(system.arm), system.joints, variant, node),
        *(begun_ns, cycle_ns, system.back_ns),
    )
    for heard in scene.after:
        evidence.take(heard)
    others = _ended(system)
    if shown_ns is None:
        others["effect"] = None
    if over_ns is not None:
        others.update(_silenced((over_ns - begun_ns) / cycle_ns))
    return evidence.facts(injected=system.cycles, left=left, **others)


def _silenced(cycles: float) -> dict[str, Any]:
    """What is known where no bus is left: no process is there that could drive a joint."""
    after = round(cycles, 2)
    off = int(Reaction.OFF)
    return {
        "stopped": after,
        "reached": after,
        "rest": after,
        "reactions": [off] * len(JOINTS),
        "others": off,
    }


def _ended(system: System) -> dict[str, Any]:
    """What the commands tell."""
    result = system.result
    fault = None if result is None else result.fault
    told = fault or system.up.complaint
    found = _NAMES.match(told)
    named = BUS if _GONE.search(told) else found.group() if found else ""
    unrecorded = [] if result is None else result.unrecorded
    return {
        "named": named,
        "told": told,
        "exit_code": system.up.exit_code or 0,
        "counted": 0.0 if unrecorded else None,
        "held": result is not None and result.incomplete > 0,
        "unrecorded": unrecorded,
    }


def _write(system: System, path: Path) -> None:
    """What the stranger heard, as a candump log."""
    writer = CandumpWriter(path, system.interface)
    for at_ns, frame in system.tape.frames:
        writer.write(at_ns, frame)
    writer.close()
