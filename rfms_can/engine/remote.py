"""What runs on a worker of a cluster: a look at its version, then a job."""

import os
import sys
from functools import cache
from typing import Any

import cloudpickle

from rfms_can.engine.processes import portable
from rfms_can.engine.stamp import CHECKOUT, Stamp
from rfms_can.errors import EngineError


class RefusedError(EngineError):
    """A worker that must not be given jobs."""


@cache
def refusal(ours: Stamp) -> str:
    """Why this process must not compute jobs of ``ours``; "" if it may.

    The folders of the checkout that the jobs' code lies in are on its path afterwards.
    """
    folders = tuple(name for name, _ in ours.folders)
    differences = ours.differences(Stamp.here(folders))
    if differences:
        return f"has another version, in {CHECKOUT}: {'; '.join(differences)}"
    for name in folders:
        path = str(CHECKOUT / name)
        if path not in sys.path:
            sys.path.insert(0, path)
    return ""


def perform(ours: Stamp, one: bytes, job: bytes) -> tuple[bytes, BaseException | None]:
    """The result of a job, pickled, or what it raised.

    Raises:
        RefusedError: this worker is of another version.
    """
    why = refusal(ours)
    if why:
        raise RefusedError(f"process {os.getpid()} {why}")
    try:
        return cloudpickle.dumps(_function(one)(cloudpickle.loads(job))), None
    except Exception as error:
        return b"", portable(error)


@cache
def _function(one: bytes) -> Any:
    return cloudpickle.loads(one)
