"""Faults put into a whole system that moves, and how it finds, names and survives them."""
