"""The node protocol, and the common parts of all nodes."""
