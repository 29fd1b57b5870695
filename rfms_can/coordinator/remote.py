"""A program's link to a server over sockets: sequential requests, and a renewed lease.

All threads share one session: a lock serialises requests with their replies, because the server
repeats the reply to a request only until a later one has come. A thread renews the lease while the
program computes; while it waits for the server, the wait itself does.
"""

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Final

from rfms_can.coordinator.conversation import (
    ANSWER_S,
    RETRY_S,
    Conversation,
    Lease,
    Request,
    answer_of,
)
from rfms_can.coordinator.sockets import Socket
from rfms_can.coordinator.stopping import stopped
from rfms_can.errors import RfmsError
from rfms_can.messages import (
    Answer,
    AnyCondition,
    AnyRequest,
    ArmRequest,
    LeaseRequest,
    MoveOutcome,
    OutcomeQuery,
    Reply,
    SensorRequest,
    Status,
    StopRequest,
    WaitRequest,
)

SLICE_S: Final = 0.1
"""Period of the calls of ``interrupted`` and ``watch`` during a wait, s."""


class RemoteLink:
    """``Link`` on a server's sockets.

    Args:
        socket: connected; the caller closes it.
        name: of this coordinator, shown to others that are refused.
        lease_s: time without a renewal after which the server stops the arm, s.
        lease: what is kept instead of the lease on the arm; None: that.
        interrupted: whether the program is to end; called while it waits.
        watch: called periodically with the arm's state while the program waits.
        now: local time, s, monotonic.
    """

    def __init__(
        self,
        socket: Socket,
        name: str,
        lease_s: float,
        *,
        lease: Lease | None = None,
        interrupted: Callable[[], bool] = lambda: False,
        watch: Callable[[Status], None] = lambda _: None,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._socket = socket
        self._lease = lease or Lease(name, lease_s)
        self._interrupted = interrupted
        self._watch = watch
        self._now = now
        self._conversation = Conversation(socket.address)
        self._lock = threading.Lock()
        self._waiting = 0
        self._early: Reply | None = None
        self._left = threading.Event()
        self._keeper: threading.Thread | None = None

    # --- the lease ----------------------------------------------------------------------------

    def acquire(self) -> None:
        """Take the lease and keep it.

        Raises:
            LeaseError: another coordinator controls the arm.
            LinkError: the server does not answer.
        """
        self.request(self._lease.acquire)
        self._keeper = threading.Thread(target=self._keep, name="lease", daemon=True)
        self._keeper.start()

    def stop_moving(self) -> None:
        """Bring the arm to rest on its path and wait for it; ``interrupted`` is ignored."""
        self._interrupted = lambda: False
        self.request(StopRequest())
        self.wait(*stopped(self.status()))

    def renew(self) -> None:
        """Renew the lease now; the arm's state is that of the reply."""
        self.request(self._lease.renew)

    def release(self) -> None:
        """Release the lease, if the server still answers; a moving arm is stopped."""
        self._left.set()
        if self._keeper is not None:
            self._keeper.join()
        with suppress(RfmsError):  # it has lapsed, or will
            self.request(self._lease.release)

    def _keep(self) -> None:
        """Renew the lease unless a request of the program is in progress."""
        while not self._left.wait(self._lease.renewal_s):
            if self._lock.acquire(blocking=False):
                try:
                    self._exchange(self._lease.renew)
                except RfmsError:
                    return  # the program's next request raises it
                finally:
                    self._lock.release()

    # --- requests -----------------------------------------------------------------------------

    def request(self, message: ArmRequest | LeaseRequest | SensorRequest) -> Answer:
        """Send a request; it is sent again, with the same number, if no reply comes.

        Raises:
            RfmsError: the server refuses it, see ``Link.request``.
        """
        with self._lock:
            return self._exchange(message)

    def wait(self, *any_of: AnyCondition) -> None:
        """Let time advance until one of the conditions holds.

        Raises:
            RfmsError: see ``Link.wait``.
            KeyboardInterrupt: ``interrupted`` returned True.
        """
        with self._lock:
            wait = self._conversation.number(WaitRequest(list(any_of)))
            self._waiting = wait.serial
            self._socket.send(wait.data)
            try:
                answer_of(self._awaited(wait))
            finally:
                self._waiting, self._early = 0, None

    def outcomes(self, first: int, last: int) -> list[MoveOutcome]:
        """How moves ended; see ``Link.outcomes``."""
        with self._lock:
            return self._exchange(OutcomeQuery(first, last)).outcomes

    def status(self) -> Status:
        """The newest state of the arm, of the last reply or a later broadcast."""
        with self._lock:
            self._look()
            return self._conversation.status

    def time(self) -> float:
        """The server's time, s."""
        with self._lock:
            self._look()
            return self._conversation.time(self._now())

    # --- replies ------------------------------------------------------------------------------

    def _exchange(self, message: AnyRequest) -> Answer:
        request = self._conversation.ask(message)
        until = self._now() + ANSWER_S
        while self._now() < until:
            self._socket.send(request.data)
            reply = self._reply(request, RETRY_S)
            if reply is not None:
                return answer_of(reply)
        raise self._conversation.silent()

    def _awaited(self, wait: Request) -> Reply:
        """The reply to a wait, however long it takes; meanwhile the lease is renewed.

        The wait is sent again with every renewal: a connection that was cut has lost it or its
        reply, and the server processes it once.
        """
        renewal_s = self._lease.renewal_s
        renew_at = self._now() + renewal_s
        while (reply := self._reply(wait, min(SLICE_S, renewal_s))) is None:
            if self._interrupted():
                raise KeyboardInterrupt
            self._look()
            self._watch(self._conversation.status)
            if self._now() >= renew_at:
                self._socket.send(wait.data)  # its reply may be lost: it is then repeated
                self._exchange(self._lease.renew)
                renew_at = self._now() + renewal_s
        return reply

    def _reply(self, request: Request, timeout_s: float) -> Reply | None:
        """The reply to a request, or None; an earlier reply to a wait is kept."""
        until = self._now() + timeout_s
        while True:
            if request.serial == self._waiting and self._early is not None:
                return self._early
            left = until - self._now()
            data = self._socket.receive(left) if left > 0.0 else None
            if data is None:
                return None
            reply = self._conversation.read(data, self._now())
            if reply.serial == request.serial:
                return reply
            if reply.serial == self._waiting:
                self._early = reply

    def _look(self) -> None:
        data = self._socket.newest_status(0.0)
        if data is not None:
            self._conversation.hear(data, self._now())
