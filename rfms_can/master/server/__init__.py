"""The server: what coordinators say over the link becomes requests of the supervisor. No I/O."""
