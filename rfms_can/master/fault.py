"""Why the master halts the arm: in words, with the culprit that they are about."""

from typing import NamedTuple

from rfms_can.messages.culprit import Culprit


class Fault(NamedTuple):
    """A reason to halt the arm.

    Attributes:
        words: in one line.
        culprit: who is to blame, and by what; its sender is empty where no one is known.
    """

    words: str
    culprit: Culprit
