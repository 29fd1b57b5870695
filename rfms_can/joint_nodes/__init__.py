"""Joint nodes: own inverse solution, error exchange, servo; and the gripper node."""
