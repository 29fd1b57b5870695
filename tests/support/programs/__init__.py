"""What tests run.

Programs that ``rfms run`` takes too: ``short_program`` (a joint and a straight segment, and the
gripper), ``there_and_back`` (one path in three modes), ``short_peg`` (the end of an insertion).
Besides, moves drawn at random (``random_moves``), the tasks of the planners' bench
(``planner_tasks``), and what runs through tools/with-vcan (``with_vcan_probe``).
"""
