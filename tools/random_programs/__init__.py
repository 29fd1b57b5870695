"""Random programs against the promise that what is accepted is made.

``draw.py`` draws a program from a seed, ``joints.py`` has the six joints as their nodes are,
``trial.py`` runs one, ``campaign.py`` many, and ``fine.py`` looks at what was refused a hundred
times as closely as the planner does.
"""
