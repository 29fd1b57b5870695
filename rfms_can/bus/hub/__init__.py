"""The hub: a bus server on a Unix socket, for processes on a kernel without CAN."""
