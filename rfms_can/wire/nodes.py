"""The nodes of the bus: their numbers and names."""

from typing import Final

JOINTS: Final = (1, 2, 3, 4, 5, 6)
GRIPPER: Final = 7
MASTER: Final = 8
PLANT: Final = 9
FORCE_SENSOR: Final = 10
BOARDS: Final = {driven: 10 + driven for driven in (*JOINTS, GRIPPER)}
"""Node number of the board of each joint and of the gripper, where boards are nodes themselves."""
SIMULATED: Final = (*JOINTS, GRIPPER, MASTER, PLANT)
"""The nodes of a bus whose boards and sensor are the plant's: all that we have programs for."""
NODE_NAMES: Final = {
    **{n: f"joint {n}" for n in JOINTS},
    GRIPPER: "gripper",
    MASTER: "master",
    PLANT: "plant",
    FORCE_SENSOR: "force sensor",
    **{board: f"board {driven}" for driven, board in BOARDS.items()},
}

DBC_NAMES: Final = {
    **{n: f"JOINT_{n}" for n in JOINTS},
    GRIPPER: "GRIPPER",
    MASTER: "MASTER",
    PLANT: "PLANT",
    FORCE_SENSOR: "FORCE_SENSOR",
    **{board: f"BOARD_{driven}" for driven, board in BOARDS.items()},
}
"""What the DBC calls each node."""

HEARTBEAT_EVERY: Final = 12
"""Cycles between two heartbeats of a node."""
