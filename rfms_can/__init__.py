"""A robot force and motion server over CAN FD: master, joint nodes, plant.

The system of H. Zhang, *Design and Implementation of a Robot Force and Motion
Server* (Purdue University, 1986), as a hardware-in-the-loop field bus.
"""

__version__ = "0.1.0"
