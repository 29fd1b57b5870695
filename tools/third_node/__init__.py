"""A joint node in plain, slow Python that was written from the handbook alone.

Its author had ``docs/node.md``, the pages beside it and ``dbc/rfms.dbc``, and none of the code of
``rfms_can``. It makes the numbers that ``rfms conform`` asks nodes for, and our own joint has to
agree with it; so it imports nothing of ``rfms_can``. ``README.md`` tells more.
"""

from third_node.node import Node

__all__ = ["Node"]
