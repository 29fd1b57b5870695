"""The trajectory generator: moves in, one Cartesian set-point a cycle out (thesis III.3.4)."""
