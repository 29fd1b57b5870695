"""A Dask scheduler and its workers on this machine, started as docs/campaigns.md says."""

import contextlib
import os
import re
import subprocess
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Final, Self

START_S: Final = 120.0
ALLOWED_FAILURES: Final = 1
"""Workers that may be lost over a job, besides the one it is given up with."""


class DaskProcess:
    """A scheduler or a worker.

    Attributes:
        address: of it.
        pid: its process.
    """

    def __init__(self, module: str, address: str, *words: str, env: Mapping[str, str]) -> None:
        command = [
            sys.executable,
            "-P",
            "-m",
            f"distributed.cli.{module}",
            *words,
            "--no-dashboard",
        ]
        self._process = subprocess.Popen(
            command, stderr=subprocess.PIPE, text=True, env={**os.environ, **env}
        )
        self._address = re.compile(address)
        self._up = threading.Event()
        self._log: list[str] = []
        self.pid = self._process.pid
        self.address = ""
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            self._log.append(line)
            found = self._address.search(line)
            if found and not self.address:
                self.address = found[1]
            if self.address and re.search(r"Registered to|Scheduler at", line):
                self._up.set()

    def wait(self) -> Self:
        """Until it is up."""
        assert self._up.wait(START_S), "".join(self._log)
        return self

    def kill(self) -> None:
        """At once."""
        self._process.kill()
        self._process.wait()

    @property
    def alive(self) -> bool:
        """Whether it runs."""
        return self._process.poll() is None


class DaskCluster:
    """A scheduler with workers of one thread each, all on loopback.

    Args:
        root: of the code that the workers have.
        env: of all of them.
        protocol: ``tcp`` or ``tls``.
    """

    def __init__(
        self, root: Path, env: Mapping[str, str] | None = None, protocol: str = "tcp"
    ) -> None:
        self._protocol = protocol
        self._env = {
            "PYTHONPATH": str(root),
            "OMP_NUM_THREADS": "1",
            "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": str(ALLOWED_FAILURES),
            **(env or {}),
        }
        words = ("--host", f"{protocol}://127.0.0.1:0")
        self.scheduler = DaskProcess(
            "dask_scheduler", r"Scheduler at: +(\S+)", *words, env=self._env
        ).wait()
        self.address = self.scheduler.address
        self.workers: list[DaskProcess] = []

    def start(self, *words: str, env: Mapping[str, str] | None = None) -> DaskProcess:
        """Another worker."""
        threads = words or ("--nthreads", "1")
        worker = DaskProcess(
            *("dask_worker", r"Start worker at: +(\S+)"),
            *(self.address, "--no-nanny", "--host", f"{self._protocol}://127.0.0.1", *threads),
            env={**self._env, **(env or {})},
        )
        self.workers.append(worker)
        return worker

    def have(self, count: int) -> list[DaskProcess]:
        """So many workers that run."""
        self.workers = [worker for worker in self.workers if worker.alive]
        while len(self.workers) < count:
            self.start()
        return [worker.wait() for worker in self.workers]

    def close(self) -> None:
        """End all."""
        for process in (*self.workers, self.scheduler):
            with contextlib.suppress(ProcessLookupError):
                process.kill()
