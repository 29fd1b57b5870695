"""Campaigns on a Dask cluster: the same tables as with processes; what is not safe is refused."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest
from support.dask_cluster import ALLOWED_FAILURES, DaskCluster

from rfms_can.engine import backend_of, run
from rfms_can.engine.address import checked, is_loopback
from rfms_can.engine.stamp import BUNDLED, CHECKOUT, PACKAGE, Stamp
from rfms_can.errors import EngineError, JobError

ROOT: Final = Path(__file__).parents[1]
CORNERS: Final = ("tools/corner_campaign.py", "--seeds", "6", "--arm", "puma260")
"""A second or two."""
LIMIT_S: Final = 180.0


@pytest.fixture(scope="module")
def cluster() -> Iterator[DaskCluster]:
    made = DaskCluster(ROOT)
    made.start()
    made.start()
    yield made
    made.close()


def tool(*words: str | Path) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, *map(str, words)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )


# --- the same results ----------------------------------------------------------------------------


@pytest.mark.processes
def test_a_campaign_whose_worker_is_killed_has_the_table_of_processes(
    cluster: DaskCluster, tmp_path: Path
) -> None:
    """And the same file, to the byte."""
    files = tmp_path / "cluster.jsonl", tmp_path / "processes.jsonl"
    first, _ = cluster.have(2)
    on_cluster = tool(*CORNERS, "--cluster", cluster.address, "--keep", files[0])
    until = time.monotonic() + LIMIT_S
    while not files[0].exists() or files[0].read_bytes().count(b"\n") < 3:
        assert time.monotonic() < until and on_cluster.poll() is None, on_cluster.communicate()
        time.sleep(0.01)
    first.kill()
    assert files[0].read_bytes().count(b"\n") < 7, "killed too late"
    table, complaints = on_cluster.communicate(timeout=LIMIT_S)
    assert on_cluster.returncode == 0, complaints
    with_processes = tool(*CORNERS, "--workers", "2", "--keep", files[1])
    assert table == with_processes.communicate(timeout=LIMIT_S)[0]
    assert "| all |  | 6 | 6 |" in table
    assert files[0].read_bytes() == files[1].read_bytes()


@pytest.mark.processes
def test_a_lost_worker_has_its_job_done_again(cluster: DaskCluster, tmp_path: Path) -> None:
    def one(number: int) -> int:
        flag = tmp_path / str(number)
        if number == 3 and not flag.exists():
            flag.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return number

    cluster.have(2)
    backend = backend_of(None, cluster.address)
    assert list(run(one, range(6), backend, in_order=True)) == list(range(6))
    assert sum(worker.alive for worker in cluster.workers) == 1


@pytest.mark.processes
def test_a_job_that_raises_or_kills_every_worker_is_named(cluster: DaskCluster) -> None:
    cluster.have(2)
    backend = backend_of(None, cluster.address)
    with pytest.raises(JobError, match=r"^job 0: ZeroDivisionError: division by zero$"):
        list(run(lambda number: 1 / number, [1, 2, 0], backend))
    with pytest.raises(JobError, match=r"^job 9: given up after 2 workers were lost over it, the"):
        list(run(lambda _: os.kill(os.getpid(), signal.SIGKILL), [9], backend))
    assert sum(worker.alive for worker in cluster.workers) == 2 - (ALLOWED_FAILURES + 1)


@pytest.mark.processes
def test_a_lost_scheduler_ends_the_campaign() -> None:
    own = DaskCluster(ROOT)
    try:
        own.have(1)
        results = run(time.sleep, [0.0, *[30.0] * 9], backend_of(None, own.address))
        next(results)
        own.scheduler.kill()
        with pytest.raises(EngineError, match=r"the scheduler was lost; with --keep the same"):
            next(results)
    finally:
        own.close()


# --- what is refused -----------------------------------------------------------------------------


@pytest.mark.processes
def test_workers_of_another_version_or_with_threads_are_refused(
    cluster: DaskCluster, tmp_path: Path
) -> None:
    for name in (PACKAGE.name, "tools", "dbc"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    with (tmp_path / PACKAGE.name / "__init__.py").open("a") as file:
        file.write("# another version\n")
    cluster.have(1)
    older = {"PYTHONPATH": str(tmp_path)}, ("--nthreads", "1")
    here = Stamp.here().code
    another = rf"has another version, in {tmp_path}: rfms_can [0-9a-f]+, not {here}$"
    threads: tuple[dict[str, str], tuple[str, ...]] = {}, ("--nthreads", "2")
    for (env, words), says in (
        (older, another),
        (threads, "has 2 threads: start it with --nthreads 1$"),
    ):
        worker = cluster.start(*words, env=env).wait()
        backend = backend_of(None, cluster.address, folders=("tools",))
        with pytest.raises(EngineError, match=rf"worker {worker.address} {says}"):
            list(run(abs, range(3), backend))
        worker.kill()


@pytest.mark.processes
def test_tls_needs_certificates_and_then_works(tmp_path: Path) -> None:
    import dask

    from rfms_can.engine.cluster import CERTIFICATES

    if shutil.which("openssl") is None:
        pytest.skip("no openssl to make certificates with: apt-get install openssl")
    with pytest.raises(EngineError, match="no certificates: set DASK_DISTRIBUTED__COMM__TLS__CA"):
        backend_of(None, "tls://127.0.0.1:8786")
    key, certificate = tmp_path / "key.pem", tmp_path / "cert.pem"
    subprocess.run(
        [
            *("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2"),
            *("-subj", "/CN=campaigns", "-keyout", key, "-out", certificate),
        ],
        check=True,
        capture_output=True,
    )
    files = {"CA_FILE": certificate}
    for role in ("CLIENT", "SCHEDULER", "WORKER"):
        files |= {f"{role}__CERT": certificate, f"{role}__KEY": key}
    env = {f"DASK_DISTRIBUTED__COMM__TLS__{name}": str(path) for name, path in files.items()}
    ours = {key: env[name] for name, key in CERTIFICATES.items()}
    with dask.config.set(ours):
        own = DaskCluster(ROOT, {**env, "DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION": "1"}, "tls")
        try:
            own.have(1)
            assert own.address.startswith("tls://")
            backend = backend_of(None, own.address)
            assert list(run(abs, [-1, 2], backend, in_order=True)) == [1, 2]
        finally:
            own.close()
        key.write_text("no key")
        with pytest.raises(EngineError, match="certificates that cannot be read"):
            backend_of(None, "tls://127.0.0.1:8786")


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("tcp://10.0.0.7:8786", "runs any code that reaches its port, so tcp:// is for loopback"),
        ("tcp://cluster.example:8786", "give tls://cluster.example:8786 with certificates"),
        ("tcp://[2001:db8::1]:8786", "so tcp:// is for loopback"),
        ("tcp://127.0.0.1.example:8786", "so tcp:// is for loopback"),
        ("tcp://0.0.0.0:8786", "so tcp:// is for loopback"),
        ("127.0.0.1:8786", "give tcp://127.0.0.1:PORT or tls://HOST:PORT"),
        ("tcp://127.0.0.1", "give tcp://127.0.0.1:PORT or tls://HOST:PORT"),
        ("tcp://127.0.0.1:many", "give tcp://127.0.0.1:PORT or tls://HOST:PORT"),
        ("ucx://127.0.0.1:8786", "give tcp://127.0.0.1:PORT or tls://HOST:PORT"),
        ("ws://127.0.0.1:8786", "give tcp://127.0.0.1:PORT or tls://HOST:PORT"),
        ("", "give tcp://127.0.0.1:PORT or tls://HOST:PORT"),
    ],
)
def test_an_address_that_is_not_safe_is_refused_with_the_reason(address: str, says: str) -> None:
    with pytest.raises(EngineError, match=re.escape(says)) as told:
        backend_of(None, address)
    assert "\n" not in str(told.value)


def test_addresses_of_this_machine_and_tls_may_be_connected_to() -> None:
    for host in ("127.0.0.1", "127.3.2.1", "[::1]", "localhost"):
        assert is_loopback(f"tcp://{host}:1")
        assert checked(f"tcp://{host}:8786")
    assert checked("tls://cluster.example:8786")


def test_a_scheduler_that_does_not_answer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    import rfms_can.engine.cluster

    monkeypatch.setattr(rfms_can.engine.cluster, "CONNECT_S", 0.2)
    backend = backend_of(None, "tcp://127.0.0.1:9")
    with pytest.raises(EngineError, match=r"^cluster tcp://127.0.0.1:9: no Dask scheduler answers"):
        list(run(abs, [1], backend))


def test_without_dask_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "rfms_can.engine.cluster", raising=False)
    with pytest.raises(EngineError, match=r"Dask is not installed here .*'rfms_can\[scale\]'$"):
        backend_of(None, "tcp://127.0.0.1:8786")


# --- versions ------------------------------------------------------------------------------------


def test_a_stamp_tells_what_differs() -> None:
    ours = Stamp.here(("tools", "no such folder"))
    assert ours.differences(ours) == []
    assert dict(ours.folders)["no such folder"] == ""
    assert "mujoco" in dict(ours.libraries)
    libraries = tuple(
        (name, "1.0" if name == "mujoco" else version) for name, version in ours.libraries
    )
    theirs = ours._replace(code="0", folders=(("tools", ""),), python="3.1", libraries=libraries)
    mujoco = dict(ours.libraries)["mujoco"]
    assert ours.differences(theirs) == [
        f"rfms_can 0, not {ours.code}",
        f"Python 3.1, not {ours.python}",
        f"tools missing, not {dict(ours.folders)['tools']}",
        f"mujoco 1.0, not {mujoco}",
    ]


def test_a_checkout_has_the_stamp_of_what_is_installed_from_it() -> None:
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    forced = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert {source: f"{PACKAGE.name}/{inside}" for source, inside in BUNDLED.items()} == forced
    assert all((CHECKOUT / source).is_file() for source in BUNDLED)
