"""The hub: the bus as a server on a Unix socket, where processes meet without CAN in the kernel."""
