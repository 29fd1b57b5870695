#!/usr/bin/env python3
"""Cycles a second of two checkouts, interleaved: what a change of the code costs or saves.

Each tree runs the loop of its own ``tools/bench_cycle.py`` in a process of its own, both on one
processor; they take turns every few cycles, and what is compared is their processor time. So a
machine that is busy with something else slows both alike.

    python tools/bench_trees.py ../before . --pairs 400
"""

import argparse
import gc
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from statistics import median
from typing import Any

CHUNK = 30
"""Cycles of a turn."""


def serve(tree: Path) -> None:
    """Run as many cycles as each line of standard input says; answer with microseconds a cycle."""
    for path in (tree, tree / "tools"):
        sys.path.insert(0, str(path))
    os.chdir(tree)
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    import bench_cycle  # noqa: PLC0415 (of the tree)

    from rfms_can.rig.settings import RunSettings  # noqa: PLC0415

    session: Any = bench_cycle.loop(200, RunSettings())
    bench_cycle.keep_moving(session)
    master = session.master if hasattr(session, "master") else session.supervisor  # older trees
    gc.collect()
    gc.freeze()
    print("ready", flush=True)
    for line in sys.stdin:
        cycles = int(line)
        until = master.closed + cycles
        began = time.process_time()
        session.link.pass_time(lambda until=until: master.closed >= until)
        print((time.process_time() - began) / cycles * 1e6, flush=True)


class Tree:
    """A checkout whose loop runs in a process of its own."""

    def __init__(self, path: Path) -> None:
        command = [sys.executable, __file__, "--serve", str(path.resolve())]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.times: list[float] = []
        self._read()

    def _read(self) -> str:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            sys.exit("bench_trees: the loop of a tree ended; its error stands above")
        return line

    def turn(self) -> None:
        """Run a few cycles."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{CHUNK}\n")
        self._process.stdin.flush()
        self.times.append(float(self._read()))

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def main() -> None:
    """Compare, and print the ratio of cycles a second, new over old."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("trees", type=Path, nargs="*", help="the old checkout and the new one")
    parser.add_argument("--pairs", type=int, default=300, help="turns of each tree")
    parser.add_argument("--json", action="store_true", help="one JSON object")
    parser.add_argument("--serve", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve is not None:
        serve(options.serve)
        return
    if len(options.trees) != 2 or options.pairs < 1:
        parser.error("give two checkouts, the old one first, and at least one pair")
    old, new = (Tree(path) for path in options.trees)
    for pair in range(options.pairs):
        for tree in (old, new) if pair % 2 else (new, old):
            tree.turn()
    for tree in (old, new):
        tree.close()
    ratios = sorted(a / b for a, b in zip(old.times, new.times, strict=True))
    figures = {
        "old_us": median(old.times),
        "new_us": median(new.times),
        "ratio_of_medians": median(old.times) / median(new.times),
        "ratio_of_fastest": min(old.times) / min(new.times),
        "median_ratio_of_pairs": median(ratios),
        "pairs": options.pairs,
    }
    if options.json:
        print(json.dumps(figures))
        return
    print(f"{figures['old_us']:.0f} us a cycle before, {figures['new_us']:.0f} after")
    print(
        f"cycles a second, new over old: {figures['median_ratio_of_pairs']:.3f} (median of "
        f"{options.pairs} pairs), {figures['ratio_of_medians']:.3f} (medians), "
        f"{figures['ratio_of_fastest']:.3f} (fastest)"
    )


if __name__ == "__main__":
    main()
