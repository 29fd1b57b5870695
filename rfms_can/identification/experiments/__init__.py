"""Experiments on the bus: the wiring probe before servoing, the excitation motions, their data."""
