"""How frames travel: the simulated bus in virtual time, the hub, python-can."""
