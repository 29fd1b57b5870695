"""The conformance suite: one joint node, asked by a tester that is all others and speaks frames.

``lines.py`` is the way to the node: called directly, on the simulated bus, or on a port.
``tester.py`` speaks for master, board and the other joints, and holds every frame of the node to
the contract. ``table.py`` lists the checks of ``checks/``, ``runner.py`` runs them, ``report.py``
tells what came of them. What the node must compute stands in ``vectors/``.
"""
