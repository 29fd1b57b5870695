"""Rows of the nodes: the law and the gravity of each set, computed, sent, and put in force."""
