"""The master: supervisor and math processor of the thesis; T6 and the rows of each cycle."""
