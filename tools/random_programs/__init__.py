"""Random programs against the promise that what is accepted is made.

``draw.py`` draws a program from a seed, ``joints.py`` has the six joints as their nodes are, and
``judge.py`` their limits; ``trial.py`` runs one program, ``on_bus.py`` many with plant and nodes;
``fine.py`` looks at what was refused a hundred times as closely as the planner does; ``results.py``
keeps what came out, ``table.py`` tells it.
"""
