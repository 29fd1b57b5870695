"""The backend that a command asks for, by its flags."""

from collections.abc import Sequence
from typing import Final

from rfms_can.engine.address import checked
from rfms_can.engine.jobs import Backend, Serial
from rfms_can.engine.processes import Processes
from rfms_can.errors import EngineError

WORKERS_HELP: Final = "processes of this machine"
CLUSTER_HELP: Final = "Dask scheduler instead: tcp://127.0.0.1:PORT or tls://HOST:PORT"
KEEP_HELP: Final = "file of results; runs already in it are not made again"


def backend_of(
    workers: int | None, cluster: str | None, *, default: int = 1, folders: Sequence[str] = ()
) -> Backend:
    """Processes of this machine, or a cluster.

    Args:
        workers: ``--workers``: number of processes, None if it was not given.
        cluster: ``--cluster``: address of a Dask scheduler, likewise.
        default: number of processes if neither was given.
        folders: of the checkout that the jobs' code lies in, besides the package.

    Raises:
        EngineError: both were given, the number is less than 1, or the address is refused;
            or Dask is not installed.
    """
    if cluster is not None:
        if workers is not None:
            raise EngineError(
                f"--workers {workers} and --cluster {cluster}: a cluster has its own workers; "
                f"give one of the two"
            )
        return _cluster(checked(cluster), folders)
    count = default if workers is None else workers
    return Serial() if count == 1 else Processes(count)


def _cluster(address: str, folders: Sequence[str]) -> Backend:
    try:
        from rfms_can.engine.cluster import Cluster  # noqa: PLC0415
    except ImportError as error:
        raise EngineError(
            f"cluster {address}: Dask is not installed here ({error}): pip install "
            f"'rfms_can[scale]'"
        ) from error
    return Cluster(address, folders)
