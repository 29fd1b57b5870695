"""What the tests share.

=====================  =============================================================================
``bench``              one node, pumped with plain calls: the bench speaks for all that is around it
``joint_bench``        the same for a joint: its board, and the five other joints
``bus_nodes``          the smallest nodes there are, for tests of buses: talk, answer, listen
``fleet``              all nine nodes, pumped with plain calls: frames lost, repeated, delayed
``system``             programs on the simulated bus: results, rests, what happened in each cycle
``bad_nodes``          joints that are tampered with, in place of joint 3 of a simulated run
``server``             a server's core without sockets, and a real one in a thread with clients
``link``               a program's end of the link without sockets: to such a core, or to nothing
``zmtp``               a peer of ZeroMQ made of a plain socket, that does what no library would
``command_line``       ``rfms`` as a user types it
``scene``              an arm in a scene, without a bus
``trajectory``         the trajectory generator and six joints, without a bus
``planning``           the same with a planner before it
``motion``             a program's definitions and moves, without a bus or joints
``joint_run``          the same with six joints that hear it as their nodes do
``tasks``              tasks of the task level at random, what they print run as a program
``identification``     what perfect experiments on a plant record, and find out
``golden``             reads ``tests/golden``, and compares with it
``plain_node``         the node's handbook once more, line for line: a joint by its formulas alone
``wire_messages``      every message of the wire contract, values for it, cantools' word on it
``conform``            the conformance suite on nodes of this process
``dask_cluster``       a Dask scheduler and workers on this machine, as users start them
``programs``           programs as files, moves drawn at random
=====================  =============================================================================
"""
