"""Outstanding waits, one a session: answered at the end of the cycle in which a condition holds."""

from collections.abc import Sequence

from rfms_can.errors import RfmsError
from rfms_can.master.node import MasterNode
from rfms_can.master.report import holds
from rfms_can.master.server.replies import Replies, Result
from rfms_can.master.server.sessions import Session, Sessions, Wait
from rfms_can.messages import Answer, AnyCondition


class Waits:
    """Answers waits.

    Args:
        master: knows what holds.
        sessions: whose waits they are.
        replies: where answers go.
    """

    def __init__(self, master: MasterNode, sessions: Sessions, replies: Replies) -> None:
        self._master = master
        self._sessions = sessions
        self._replies = replies

    def begin(self, session: Session, wait: Wait) -> None:
        """Answer a wait at once if it holds, else keep it; an earlier one is answered with none."""
        self.end(session, Answer())
        session.wait = wait
        held = self._held(wait.any_of)
        if held:
            self.end(session, Answer(held=held))

    def end(self, session: Session, result: Result) -> None:
        """Answer the outstanding wait of a session, if there is one."""
        wait = session.wait
        if wait is None:
            return
        session.wait = None
        reply = self._replies.make(session.peer, wait.serial, result)
        session.keep(wait.serial, reply, of_wait=True)

    def answer(self, failure: RfmsError | None) -> None:
        """Answer those that hold; with a failure all of them, refused."""
        for session in self._sessions:
            if session.wait is None:
                continue
            if failure is not None:
                self.end(session, failure)
                continue
            held = self._held(session.wait.any_of)
            if held:
                self.end(session, Answer(held=held))

    def of(self, word: str | None) -> bool:
        """Whether a session has an outstanding wait."""
        return any(one.wait is not None and one.word == word for one in self._sessions)

    def _held(self, any_of: Sequence[AnyCondition]) -> list[int]:
        master = self._master
        return [index for index, one in enumerate(any_of) if holds(master, one)]
