"""The two ways ``tools/with-vcan`` has: the running kernel's vcan, and a user-mode Linux kernel."""


class Obstacle(Exception):  # noqa: N818
    """Why one of the ways is not open on this machine; a phrase, with the way out."""
