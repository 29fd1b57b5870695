"""MasterNode and math processor: T6 and the rows of each cycle, and who may move."""
