"""Trials of the coordinator's link: a client is killed, frozen, cut off or replaced in motion.

==============  ====================================================================================
``client``      the client under trial, a process of its own that says what it hears
``relay``       a TCP relay in front of a server, whose connections can be cut
``trial``       one trial from its seed: the client, what happens to it, what the server says of it
``judgement``   a trial's row, and what in it is not the truth
==============  ====================================================================================
"""
