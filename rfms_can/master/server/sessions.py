"""Who has spoken so far: serial numbers, last replies, outstanding waits. Bounded in number."""

from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from rfms_can.messages import AnyCondition

MAX_SESSIONS: Final = 64


@dataclass(slots=True)
class Wait:
    """A wait that has not been answered.

    Attributes:
        serial: its number.
        any_of: it is answered when one of them holds.
    """

    serial: int
    any_of: Sequence[AnyCondition]


@dataclass(slots=True)
class Session:
    """One coordinator's conversation.

    Attributes:
        word: its random word.
        peer: where its replies go: the last peer that spoke for it.
        serial: of the request processed last.
        wait: the outstanding one, or None.
        replies: by serial number, of the last request and of the last wait: what is repeated is
            answered as it was before.
        lost: how it lost the lease; None while it has it, after it gave it back, or if it never
            had it.
    """

    word: str
    peer: bytes = b""
    serial: int = 0
    wait: Wait | None = None
    replies: dict[int, bytes] = field(default_factory=dict)
    lost: str | None = None
    _waited: int = 0

    def knows(self, serial: int) -> bool:
        """Whether it is the number of a request whose reply is kept, or comes yet."""
        waits = self.wait is not None and self.wait.serial == serial
        return waits or serial in self.replies

    def keep(self, serial: int, reply: bytes, *, of_wait: bool) -> None:
        """Keep a reply until the next one of its kind."""
        if of_wait:
            self._waited = serial
        self.replies[serial] = reply
        for old in [key for key in self.replies if key not in (self.serial, self._waited)]:
            del self.replies[old]


class Sessions:
    """The sessions a server remembers; the one that was silent longest is forgotten first."""

    def __init__(self) -> None:
        self._sessions: OrderedDict[str, Session] = OrderedDict()

    def __len__(self) -> int:
        return len(self._sessions)

    def __iter__(self) -> Iterator[Session]:
        return iter(self._sessions.values())

    def find(self, word: str) -> Session | None:
        """A session that is remembered; it counts as used now."""
        session = self._sessions.get(word)
        if session is not None:
            self._sessions.move_to_end(word)
        return session

    def open(self, word: str, keep: str | None) -> tuple[Session, Session | None]:
        """Begin a session.

        Args:
            word: its word.
            keep: word of the session that must not be forgotten, or None.

        Returns:
            The session, and the one that had to be forgotten for it, or None.
        """
        forgotten = None
        if len(self._sessions) >= MAX_SESSIONS:
            oldest = next(old for old in self._sessions if old != keep)
            forgotten = self._sessions.pop(oldest)
        session = self._sessions[word] = Session(word)
        return session, forgotten
