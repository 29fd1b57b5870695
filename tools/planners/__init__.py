"""What came before the thesis' trajectory generator, and what is taken today, on the same tasks.

``task.py`` has the three tasks, ``planner.py`` what a planner is, and there is a file for each:
``thesis.py`` (ours), ``whitney.py``, ``paul.py`` (with ``double_turn.py``), ``taylor.py`` and
``jerk_limited.py`` (Ruckig). ``run.py`` runs and times them, ``measures.py`` and ``deviation.py``
say what came out, ``table.py`` prints it. They are for comparison only: no node uses them.
"""
