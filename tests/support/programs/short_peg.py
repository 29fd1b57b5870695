"""The last of a peg's way into its hole: the mouth, the chamfer, 10 mm deep, and out again."""

from example_run import example

program = example(
    "peg_in_hole",
    APPROACH_TIME=1.3,
    ABOVE=0.002,
    ENTRY_SPEED=0.008,
    ENTERED=0.004,
    GUIDED=0.006,
    DEPTH=0.010,
).program
