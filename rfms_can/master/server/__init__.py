"""The server: what coordinators say over the link becomes requests of the master. No I/O."""
