"""Write the tables of docs/faults.md from the table of faults and the trials in docs/data."""

from collections.abc import Sequence
from typing import Final

from generated import DOCS, main_of_pages, table

from rfms_can.arm import ARMS
from rfms_can.bus.url import HUB
from rfms_can.faults.campaign import Line, lines_of, met_rows
from rfms_can.faults.catalogue import INJECTORS, JOINT
from rfms_can.faults.context import ANYWHERE, Seam
from rfms_can.faults.judge import culprit_of
from rfms_can.faults.processes.injectors import PROCESS_INJECTORS
from rfms_can.faults.results import read
from rfms_can.faults.table import ROWS, Expected, State, Variant, Where, variants
from rfms_can.faults.trial import Result
from rfms_can.wire.nodes import MASTER, PLANT

KEPT: Final = DOCS / "data" / "faults.jsonl"
OF_PROCESSES: Final = {bus: DOCS / "data" / f"faults_{bus}.jsonl" for bus in (HUB, "vcan0")}
LONGEST_TOLD: Final = 130
_AT: Final = {JOINT: "a joint", MASTER: "the master", PLANT: "the plant"}


def _kept() -> tuple[str, list[Result]]:
    conditions, results = read(KEPT)
    return conditions.code, results


def render_summary() -> str:
    """How many rows are met, row by row."""
    code, results = _kept()
    simulated = lines_of(ROWS, list(ARMS), results)
    lines = [*simulated, *_of_processes(HUB)]
    met = met_rows(lines)
    good = [str(row) for row in sorted(met) if met[row]]
    of_lines = sum(line.met for line in lines)
    head = (
        f"{len(results)} trials on the simulated bus, {_seeds(simulated)} of each variant on each "
        f"arm, code {code}, and those of [processes](#processes) on a hub: "
        f"**{len(good)} of {len(met)} rows met**, {of_lines} of {len(lines)} lines (a variant on "
        f"one arm).\n\nMet: {', '.join(good)}."
    )
    return f"{head}\n\n{_rows(lines, met)}"


def _of_processes(bus: str) -> list[Line]:
    """A line for each variant of processes on each arm that it was tried on."""
    results = read(OF_PROCESSES[bus])[1]
    arms = sorted({result.arm for result in results})
    return lines_of(ROWS, arms, results, Where.PROCESSES)


def _seeds(lines: Sequence[Line]) -> str:
    """How many seeds each line has, in words."""
    seeds = sorted({line.seeds for line in lines if line.seeds})
    of_each = " to ".join(map(str, seeds[:1] + seeds[1:][-1:]))
    return f"{of_each} {'seed' if of_each == '1' else 'seeds'}"


def _rows(lines: Sequence[Line], met: dict[int, bool]) -> str:
    cells = []
    for number, row in ROWS.items():
        own = [line for line in lines if line.row == number]
        passed = f"{sum(line.met for line in own)} of {len(own)}"
        verdict = "**met**" if met[number] else "not met"
        cells.append(
            [str(number), row.fault, row.detected_by, row.bound, row.reaction, verdict, passed]
        )
    heads = ["row", "fault", "found by", "bound, cycles", "reaction", "today", "lines met"]
    return table(heads, cells)


def render_variants() -> str:
    """Each variant: what happens, what was measured, what is not met."""
    _, results = _kept()
    lines = lines_of(ROWS, list(ARMS), results)
    cells = []
    for row, variant in variants():
        if variant.where is Where.SIM:
            own = [line for line in lines if (line.row, line.variant) == (row, variant.name)]
            cells.append([str(row), f"`{variant.name}`", *_measured(variant, own)])
    return table(_HEADS, cells)


_HEADS: Final = [
    *("row", "variant", "bound", "found after", "wanted", "came", "today, and what is not met"),
]


def render_processes() -> str:
    """Faults of processes on each bus that they were tried on: what was measured."""
    parts = []
    for bus, file in OF_PROCESSES.items():
        if not file.exists():
            continue
        conditions, results = read(file)
        arms = sorted({result.arm for result in results})
        lines = _of_processes(bus)
        rows = met_rows(lines)
        parts.append(
            f"On {bus}: {len(results)} trials, {_seeds(lines)} of each variant on "
            f"{', '.join(arms)}, code {conditions.code}: "
            f"**{sum(rows.values())} of {len(rows)} rows met**."
        )
        cells = []
        for row, variant in variants():
            own = [line for line in lines if (line.row, line.variant) == (row, variant.name)]
            if variant.where is Where.PROCESSES:
                met = sum(r.met for r in results if (r.row, r.variant) == (row, variant.name))
                told = _measured(variant, own)
                told[-1] = f"{met} of {sum(line.seeds for line in own)}: {told[-1]}"
                cells.append([str(row), f"`{variant.name}`", *told])
        parts.append(table(_HEADS, cells))
    return "\n\n".join(parts)


def render_process_injectors() -> str:
    """Every fault of processes: how it is provoked."""
    cells = [
        [f"`{name}`", one.does, _AT[one.node], one.shows.value]
        for name, one in PROCESS_INJECTORS.items()
    ]
    return table(["name", "what is wrong then", "at", "cycles count"], cells)


def _measured(variant: Variant, own: Sequence[Line]) -> list[str]:
    wanted = variant.expected.value
    if variant.culprit:
        wanted += f", {variant.culprit} named"
    if not any(line.seeds for line in own):
        return [f"{variant.bound:g}", "", wanted, "", "not tried yet"]
    never = any(line.worst is None for line in own)
    worst = [line.worst for line in own if line.worst is not None]
    if variant.expected is Expected.NONE:
        never, worst = False, [0.0]
    found = "never, in some" if never and worst else "never" if never else f"{max(worst):.1f}"
    came = sorted({word for line in own for word in line.reaction.split(", ") if word})
    return [f"{variant.bound:g}", found, wanted, ", ".join(came), _verdict(own)]


def _verdict(own: Sequence[Line]) -> str:
    missed = [line for line in own if not line.met]
    if not missed:
        return "**met**"
    first = missed[0]
    why = "; ".join(first.why)
    if len(why) > LONGEST_TOLD:
        why = why[:LONGEST_TOLD].rsplit(" ", 1)[0] + " ..."
    return f"not met on {', '.join(line.arm for line in missed)}: {why} (`{first.replay}`)"


def render_seen() -> str:
    """What a user sees of each variant that stops the arm: the words of the first trial."""
    _, results = _kept()
    first: dict[tuple[int, str], Result] = {}
    for result in sorted(results, key=lambda r: (r.arm, r.seed)):
        if result.facts is not None and result.facts.told:
            first.setdefault((result.row, result.variant), result)
    cells = []
    for row, variant in variants():
        seen = first.get((row, variant.name))
        if seen is not None and seen.facts is not None:
            wanted = culprit_of(variant, seen.facts) or "no one"
            cells.append([f"`{variant.name}`", wanted, f"`{seen.facts.told}`"])
    return table(["variant", "at fault", "what the run ends with"], cells)


def render_injectors() -> str:
    """Every injector: how a fault is provoked."""
    cells = []
    for name, injector in INJECTORS.items():
        where = "every bus" if injector.seam in ANYWHERE else "sim"
        if injector.seam is Seam.PROGRAM:
            where = "`rfms faults` alone"
        cells.append([f"`{name}`", injector.does, _AT[injector.node], injector.seam.value, where])
    return table(["name", "what is wrong then", "at", "seam", "`rfms run --fault` on"], cells)


def render_states() -> str:
    """What the system does when a fault is put in."""
    return "\n".join(f"- `{state.name}`: {state.value}" for state in State)


PAGES = {
    "faults.md": {
        "draw_faults.py: rows": render_summary,
        "draw_faults.py: states": render_states,
        "draw_faults.py: variants": render_variants,
        "draw_faults.py: processes": render_processes,
        "draw_faults.py: process injectors": render_process_injectors,
        "draw_faults.py: seen": render_seen,
        "draw_faults.py: injectors": render_injectors,
    }
}

if __name__ == "__main__":
    main_of_pages("draw_faults.py", PAGES)
