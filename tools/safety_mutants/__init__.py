"""Mutants of the safety core: its code with one thing wrong, tried by the project's own tests."""
