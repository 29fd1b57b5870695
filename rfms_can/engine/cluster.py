"""Jobs on a Dask cluster: the same results as from processes, from other machines.

Imported only where a cluster is asked for: it needs the extra ``scale``.
"""

import logging
import queue
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import islice
from typing import Any, Final

import cloudpickle
import dask
from distributed import Client, Future
from distributed.client import FutureCancelledError
from distributed.scheduler import KilledWorker
from distributed.security import Security

from rfms_can.engine.address import WHY, checked, is_loopback
from rfms_can.engine.jobs import J, R, Work
from rfms_can.engine.remote import RefusedError, perform, refusal
from rfms_can.engine.stamp import Stamp
from rfms_can.errors import EngineError

CONNECT_S: Final = 10.0
"""Longest time until the scheduler answers, s."""
CLOSE_S: Final = 2.0
"""Longest time that taking leave of it may take, s."""
WORKERS_S: Final = 60.0
"""Longest time without any worker, s."""
LOOK_S: Final = 0.2
"""Longest time between two calls of ``tick``, s."""
COUNT_S: Final = 2.0
"""Time between two looks at the workers, s."""
CERTIFICATES: Final = {
    "DASK_DISTRIBUTED__COMM__TLS__CA_FILE": "distributed.comm.tls.ca-file",
    "DASK_DISTRIBUTED__COMM__TLS__CLIENT__CERT": "distributed.comm.tls.client.cert",
    "DASK_DISTRIBUTED__COMM__TLS__CLIENT__KEY": "distributed.comm.tls.client.key",
}
"""What Dask's configuration must have for TLS: environment variables, and the keys they set."""


class Cluster:
    """Jobs on the workers of a Dask scheduler, one at a time on each.

    Args:
        address: of the scheduler: ``tcp://`` on this machine, ``tls://`` elsewhere.
        folders: of the checkout that the jobs' code lies in, besides the package.

    Raises:
        EngineError: the address is refused, or there are no certificates for TLS.
    """

    def __init__(self, address: str, folders: Sequence[str] = ()) -> None:
        self.address: Final = checked(address)
        self._folders: Final = tuple(folders)
        self._security: Final = _certificates(address) if address.startswith("tls:") else None

    def results(self, work: Work[J, R]) -> Iterator[tuple[int, R]]:
        """See ``Backend``.

        Raises:
            EngineError: the scheduler does not answer or was lost, or it has no workers; or one of
                them is reached without TLS, has more than one thread, or is of another version.
        """
        client = _connected(self.address, self._security)
        try:
            yield from _Campaign(client, self.address, Stamp.here(self._folders), work).results()
        finally:
            with suppress(TimeoutError):  # a scheduler that was lost
                client.close(timeout=CLOSE_S)


def _certificates(address: str) -> Security:
    missing = [name for name, key in CERTIFICATES.items() if not dask.config.get(key, None)]
    if missing:
        raise EngineError(f"cluster {address}: no certificates: set {', '.join(missing)}")
    security = Security(require_encryption=True)
    try:
        security.get_connection_args("client")
    except OSError as error:
        raise EngineError(
            f"cluster {address}: certificates that cannot be read: {error}"
        ) from error
    return security


def _connected(address: str, security: Security | None) -> Client:
    for name in ("client", "core", "comm"):  # what goes wrong is told in one line, not in logs too
        logging.getLogger(f"distributed.{name}").setLevel(logging.CRITICAL)
    try:
        return Client(address, timeout=CONNECT_S, security=security, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise EngineError(
            f"cluster {address}: no Dask scheduler answers ({' '.join(str(error).split())}): start "
            f"one, as docs/campaigns.md says"
        ) from error


class _Campaign:
    """Jobs on the workers of a connected scheduler.

    No worker is given a second job while it has one: when a worker is lost, Dask blames every job
    that it had.
    """

    def __init__(self, client: Client, address: str, stamp: Stamp, work: "Work[Any, Any]") -> None:
        self._client = client
        self._address = address
        self._stamp = stamp
        self._work = work
        self._done: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
        self._waiting: dict[Future[Any], tuple[int, Any]] = {}
        self._workers: set[str] = set()
        self._counted = self._seen = 0.0

    def results(self) -> Iterator[tuple[int, Any]]:
        """As they come."""
        one = cloudpickle.dumps(self._work.one)
        jobs = enumerate(self._work.jobs)
        self._seen = time.monotonic()
        try:
            while True:
                self._count()
                for index, job in islice(jobs, max(0, len(self._workers) - len(self._waiting))):
                    self._submit(one, index, job)
                if not self._waiting and self._workers:
                    return
                with suppress(queue.Empty):
                    yield self._finished(self._done.get(timeout=LOOK_S))
                self._work.tick()
        finally:
            if self._client.status == "running":
                self._client.cancel(list(self._waiting), force=True)

    def _submit(self, one: bytes, index: int, job: Any) -> None:
        try:
            sent = cloudpickle.dumps(job)
        except Exception as error:  # whatever an object raises that cannot be pickled
            raise self._work.failed(job, error) from error
        future = self._client.submit(perform, self._stamp, one, sent, pure=False)
        self._waiting[future] = index, job
        future.add_done_callback(self._done.put)

    def _finished(self, future: "Future[Any]") -> tuple[int, Any]:
        """The number and the result of a job that is done."""
        index, job = self._waiting.pop(future)
        try:
            result, error = future.result()
        except KilledWorker as killed:
            how = f"{killed.last_worker.address}"
            raise self._work.given_up(job, killed.allowed_failures + 1, how) from killed
        except RefusedError as refused:
            raise EngineError(f"cluster {self._address}: a worker, {refused}") from refused
        except (FutureCancelledError, OSError) as lost:
            raise self._lost() from lost
        except Exception as raised:  # Dask's own, on the way
            raise self._work.failed(job, raised) from raised
        if error is not None:
            raise self._work.failed(job, error) from error
        return index, cloudpickle.loads(result)

    def _count(self) -> None:
        """Look at the workers now and then; those that are new are checked."""
        if self._client.status != "running":  # Dask cancels all jobs before it connects again
            raise self._lost()
        now = time.monotonic()
        if self._workers and now - self._counted < COUNT_S:
            return
        self._counted = now
        try:
            workers = self._client.scheduler_info()["workers"]
        except (OSError, TimeoutError, KeyError) as error:
            raise self._lost() from error
        new = {address: about for address, about in workers.items() if address not in self._workers}
        self._check({address: int(about["nthreads"]) for address, about in new.items()})
        self._workers = set(workers)
        if workers:
            self._seen = now
        elif now - self._seen > WORKERS_S:
            raise EngineError(
                f"cluster {self._address}: no worker for {WORKERS_S:.0f} s: start workers, as "
                f"docs/campaigns.md says; with --keep the same command goes on"
            )

    def _check(self, threads: dict[str, int]) -> None:
        """Refuse workers that must not be given jobs."""
        for address, count in threads.items():
            if not address.startswith("tls:") and not is_loopback(address):
                raise self._refused(address, f"is reached without TLS, and {WHY}")
            if count != 1:
                raise self._refused(address, f"has {count} threads: start it with --nthreads 1")
        if not threads:
            return
        answers = self._client.run(refusal, self._stamp, workers=list(threads), on_error="return")
        for address, answer in answers.items():
            if isinstance(answer, OSError):
                continue  # it is gone already
            if isinstance(answer, BaseException):
                answer = f"has another version: {type(answer).__name__}: {answer}"  # noqa: PLW2901
            if answer:
                raise self._refused(address, answer)

    def _refused(self, worker: str, why: str) -> EngineError:
        return EngineError(f"cluster {self._address}: worker {worker} {why}")

    def _lost(self) -> EngineError:
        return EngineError(
            f"cluster {self._address}: the scheduler was lost; with --keep the same command goes "
            f"on where it was"
        )
