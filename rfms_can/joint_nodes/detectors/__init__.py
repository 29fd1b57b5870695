"""What a joint finds wrong with its board, drive, rows and bus (docs/node-detectors.md).

Each watch is plain state: it takes numbers and says what is wrong, and knows nothing of faults,
states or frames. Who asks it counts the fault or lets it trip.
"""
