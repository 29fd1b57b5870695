"""The link between coordinators and the server: ZeroMQ sockets at either end, addresses, keys."""
