"""Dynamics of an arm: the rigid body, the thesis' simpler models, and those fitted to data."""
