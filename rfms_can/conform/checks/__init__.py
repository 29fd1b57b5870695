"""The checks, by what they are about; each is a function of the tester that raises on a failure."""
