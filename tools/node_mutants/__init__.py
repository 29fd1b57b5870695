"""Mutants of the joint node: its code with one thing wrong, by operators and by hand."""
