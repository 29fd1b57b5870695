"""The lease: the control of the arm, which one coordinator has at a time and must keep renewing."""

from rfms_can.errors import LeaseError


class Lease:
    """Who controls the arm, and until when.

    Attributes:
        holder: word of the session that has it, or None.
        name: what the holder calls itself; None while it is free.
    """

    __slots__ = ("_duration_ns", "_expires_ns", "holder", "name")

    def __init__(self) -> None:
        self.holder: str | None = None
        self.name: str | None = None
        self._duration_ns = self._expires_ns = 0

    def acquire(self, word: str, name: str, duration_s: float, now_ns: int) -> None:
        """Give it to a session, or go on under a new name and duration.

        Raises:
            LeaseError: another has it.
        """
        if self.holder not in (None, word):
            raise self._taken(now_ns)
        self.holder, self.name = word, name
        self._duration_ns = round(duration_s * 1e9)
        self.renew(now_ns)

    def check(self, word: str, now_ns: int) -> None:
        """See that a session has it.

        Raises:
            LeaseError: another session has it, or none has.
        """
        if self.holder is None:
            raise LeaseError(
                "this session does not control the arm, or no longer: acquire the lease first"
            )
        if self.holder != word:
            raise self._taken(now_ns)

    def renew(self, now_ns: int) -> None:
        """It lasts its whole duration from now on."""
        self._expires_ns = now_ns + self._duration_ns

    def extend(self, duration_s: float, now_ns: int) -> None:
        """Renew it with another duration."""
        self._duration_ns = round(duration_s * 1e9)
        self.renew(now_ns)

    def free(self) -> None:
        """Give it back: no session has it."""
        self.holder = self.name = None

    def lapsed(self, now_ns: int) -> bool:
        """Whether it has not been renewed in time."""
        return self.holder is not None and now_ns >= self._expires_ns

    def _taken(self, now_ns: int) -> LeaseError:
        left_s = max(0, self._expires_ns - now_ns) * 1e-9
        return LeaseError(
            f"the arm is controlled by {self.name!r}, for {left_s:.2f} s yet if it does not renew "
            f"its lease: wait until it is given back or lapses"
        )
