"""Servoing runs: an arm that follows what a camera sees, with all that cameras do.

``scene.py`` draws a run from a seed: where the part goes, and what the camera makes of it;
``trial.py`` runs it; ``results.py`` keeps it, ``table.py`` tells what came out.
"""
