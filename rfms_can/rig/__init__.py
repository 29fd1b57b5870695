"""The test rig: puts nodes on a bus, runs a program against them, records the run."""
