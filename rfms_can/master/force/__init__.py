"""Force: what complies, what is pushed with, when a move is stopped by what it meets (Ch. V)."""
