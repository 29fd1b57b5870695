#!/usr/bin/env python3
"""Draw what the examples with sensors and functional transforms do: docs/images/*.png.

Each picture is of runs on the simulated bus, made for it: the tool by the encoders and the direct
kinematics, the part where it truly was at the same moments.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
from example_run import EXAMPLES, example, on_the_belt, origin, run_example

from rfms_can.analysis.canvas import COMMANDED, FAINT, JOINT_COLORS, LIMIT, MEASURED, Sheet
from rfms_can.transform import Transform

IMAGES = EXAMPLES.parent / "docs" / "images"
RATE = 250.0


def conveyor(out: Path) -> Path:
    """The tool's distance from the part, from the first picture to the grip."""
    sheet = Sheet(
        "A part on a belt",
        "PUMA 560, pictures 20 ms old, 50 a second",
        (2, 1),
        (7.5, 5.2),
        (1.0, 1.2),
    )
    along = sheet.title_panel(0, "Along the belt", "m")
    error = sheet.title_panel(1, "Tool less part", "mm")
    for speed, color in zip((0.05, 0.1, 0.2), JOINT_COLORS, strict=False):
        module = example("conveyor", SPEED=speed)
        run, belt = on_the_belt(module, "puma560", "corke")
        asked = next(i for i, status in enumerate(run.statuses) if status.sequence == 2)
        lifts = next(i for i, status in enumerate(run.statuses) if status.sequence == 4)
        times = run.times[:lifts] - run.times[asked]
        parts = np.array([origin(belt.part(status.time)) for status in run.statuses[:lifts]])
        tools = run.measured_tools()[:lifts]
        middle = origin(belt.at(0.0))[1]
        shown = times > -0.4
        name = f"{1e3 * speed:.0f} mm/s"
        along.plot(times[shown], parts[shown, 1] - middle, color=FAINT, linewidth=4.0, alpha=0.4)
        along.plot(times[shown], tools[shown, 1] - middle, color=color, label=name)
        error.semilogy(
            times[shown], 1e3 * np.linalg.norm(tools - parts, axis=1)[shown], color=color
        )
    error.axhline(1.0, color=LIMIT, linewidth=0.9, linestyle="--")
    error.set_ylim(0.01, 1e3)
    sheet.legend(*along.get_legend_handles_labels())
    return sheet.save(out / "conveyor.png", "time since the approach was asked for, s")


def camera(out: Path) -> Path:
    """How the tool leaves the way it had for the one the camera gives it."""
    module = example("camera")
    run, twin = run_example("camera", "puma560"), run_example("camera", "puma560", OFF=(0, 0, 0))
    begin = next(i for i, status in enumerate(run.statuses) if status.sequence == 2)
    end = run.arrival(2)
    window = slice(begin, end)
    times = run.times[window] - run.times[begin]
    added = run.commanded_tools()[: end + 2] - twin.commanded_tools()[: end + 2]
    acceleration = np.linalg.norm(np.diff(added, n=2, axis=0), axis=1) * RATE**2
    hand = Transform(*run.statuses[0].t6)
    seen = np.array(origin(module.seen(hand)))
    left = 1e3 * (run.measured_tools()[window] - seen)
    sheet = Sheet(
        "A camera corrects the goal by 10 mm on the way",
        "examples/camera.py, PUMA 560",
        (2, 1),
        (7.5, 4.6),
    )
    axes = sheet.title_panel(0, "Tool less where the part is", "mm")
    axes.plot(times, left[:, 0], color=MEASURED, label="x")
    axes.plot(times, left[:, 1], color=COMMANDED, label="y")
    below = sheet.title_panel(1, "Acceleration the correction adds", "m/s²")
    below.plot(times, acceleration[window], color=MEASURED)
    below.axhline(module.ACCELERATION, color=LIMIT, linewidth=0.9, linestyle="--")
    sheet.legend(*axes.get_legend_handles_labels())
    return sheet.save(out / "camera.png", "time since the approach began, s")


def weave(out: Path) -> Path:
    """The torch's way over the seam, seen from above."""
    module, run = example("weave"), run_example("weave", "puma560")
    hand = run.statuses[0].t6
    seam = 1e3 * np.array(module.SEAM)
    tools = 1e3 * (run.measured_tools() - (hand[3], hand[7], hand[11] - 0.22))
    welding = [i for i, status in enumerate(run.statuses) if 3 <= status.sequence <= 5]
    sheet = Sheet(
        "A weave along a seam with two corners",
        "examples/weave.py, PUMA 560, seen from above",
        (1, 1),
        (7.5, 3.9),
    )
    axes = sheet.title_panel(0, "Torch and seam", "x, mm")
    axes.plot(seam[:, 1], seam[:, 0], color=FAINT, linewidth=4.0, alpha=0.4)
    axes.plot(tools[welding, 1], tools[welding, 0], color=MEASURED, linewidth=1.0)
    axes.set_aspect("equal")
    axes.margins(0.05)
    return sheet.save(out / "weave.png", "y, mm")


PICTURES: Final[dict[str, Callable[[Path], Path]]] = {
    "conveyor": conveyor,
    "camera": camera,
    "weave": weave,
}


def main() -> None:
    """Draw them all, or those named."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", help=f"of {', '.join(PICTURES)}; all if none is named")
    parser.add_argument("--out", type=Path, default=IMAGES)
    options = parser.parse_args()
    for name in options.names or PICTURES:
        print(PICTURES[name](options.out))


if __name__ == "__main__":
    main()
