"""Numbers and names of the nodes on the bus."""

from typing import Final

JOINTS: Final = (1, 2, 3, 4, 5, 6)
GRIPPER: Final = 7
MASTER: Final = 8
PLANT: Final = 9
NODE_NAMES: Final = {**{n: f"joint {n}" for n in JOINTS}, 7: "gripper", 8: "master", 9: "plant"}

HEARTBEAT_EVERY: Final = 12
"""Cycles between two heartbeats of a node."""
