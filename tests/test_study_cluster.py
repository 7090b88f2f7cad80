"""The study on Dask: the same numbers, whatever becomes of a worker."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
from contextlib import closing, contextmanager

import pytest

import studies
from tegotae.cli import main
from tegotae.errors import TegotaeError
from tegotae.study import runner
from tegotae.study.cluster import on_cluster
from tegotae.study.folder import Folder
from tegotae.study.plan import plan

distributed = pytest.importorskip("distributed")


@contextmanager
def cluster(workers: int):
    with distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        dashboard_address=None,
        silence_logs=50,
    ) as found:
        yield found


def when_at_work(cluster, action):
    """A thread that waits until a worker is at work, and then does something with that worker."""

    def watch() -> None:
        action(studies.wait_for(lambda: busy(cluster), "a worker at work"))

    thread = threading.Thread(target=watch)
    thread.start()
    return thread


def busy(cluster):
    states = list(cluster.scheduler.workers.values())
    return next((state for state in states if state.processing), None)


@pytest.fixture(autouse=True)
def compiled(smoke_study, monkeypatch):
    for name, value in studies.environment(studies.cache_of(smoke_study)).items():
        monkeypatch.setenv(name, value)


def test_a_worker_killed_during_the_run_changes_nothing(smoke_study, tmp_path):
    killed = []
    with cluster(workers=2) as two:
        pids = {nanny.worker_address: nanny.pid for nanny in two.workers.values()}

        def kill(worker) -> None:
            nanny = next(n for n in two.workers.values() if n.worker_address == worker.address)
            killed.append(nanny.pid)
            os.kill(nanny.pid, signal.SIGKILL)

        thread = when_at_work(two, kill)
        assert runner.run(plan("smoke"), tmp_path / "study", on_cluster(two.scheduler_address)) == 3
        thread.join()
    assert len(pids) == 2
    assert len(killed) == 1
    studies.assert_same(tmp_path / "study", smoke_study)


def test_a_cluster_of_this_machine_needs_no_address(smoke_study, tmp_path, capfd):
    folder = studies.copy(smoke_study, tmp_path / "study", "V", "A")
    words = ["--dir", str(folder), "--scale", "smoke", "--cluster", "local"]
    assert main(["study", "run", *words]) == 0
    out, err = capfd.readouterr()
    assert out.startswith("3 records in ")
    assert all(line.startswith("study  ") for line in err.splitlines())
    studies.assert_same(folder, smoke_study)


def serve() -> None:
    """A cluster that prints its address, and then when it is at work, and waits to be killed."""
    with cluster(workers=1) as one:
        print(one.scheduler_address, flush=True)
        studies.wait_for(lambda: busy(one), "a worker at work")
        print("at work", flush=True)
        threading.Event().wait()


def test_a_scheduler_that_goes_away_costs_the_work_in_flight(smoke_study, tmp_path):
    folder = studies.copy(smoke_study, tmp_path / "study", "V", "A")
    words = [sys.executable, "-c", "import test_study_cluster as here; here.serve()"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, sys.path))}
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, text=True, env=environment, start_new_session=True
    ) as scheduler:
        assert scheduler.stdout is not None
        address = scheduler.stdout.readline().strip()
        results = on_cluster(address)

        def kill_at_work() -> None:
            if scheduler.stdout.readline() == "at work\n":
                os.killpg(scheduler.pid, signal.SIGKILL)

        thread = threading.Thread(target=kill_at_work)
        thread.start()
        with pytest.raises(TegotaeError) as raised:
            runner.run(plan("smoke"), folder, results)
        thread.join()
    assert str(raised.value) == (
        f"the Dask scheduler at {address} went away; {folder} keeps 2 of 3 models, "
        "the same command goes on from there"
    )
    assert len(Folder(folder).all()[0]) == 2


@pytest.fixture
def closed_port() -> int:
    """A port that nothing listens at."""
    with closing(socket.socket()) as bound:
        bound.bind(("127.0.0.1", 0))
        return bound.getsockname()[1]


def test_an_unreachable_scheduler_is_said_at_once(tmp_path, one_line_error, closed_port):
    address = f"tcp://127.0.0.1:{closed_port}"
    words = ["study", "run", "--dir", str(tmp_path / "study"), "--cluster", address]
    assert one_line_error(*words) == (
        f"tegotae: no Dask scheduler can be reached at '{address}': Connection refused\n"
    )
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize(
    ("address", "why"),
    [
        ("scheduler", "missing port number in address"),
        ("", "missing port number in address"),
        ("gopher://scheduler:8786", "unknown address scheme 'gopher'"),
    ],
)
def test_what_is_no_address_is_refused(address, why):
    with pytest.raises(TegotaeError, match=r"no Dask scheduler can be reached at '.*': ") as raised:
        on_cluster(address)
    assert why in str(raised.value)


def test_something_that_is_no_scheduler_is_given_up_on():
    with closing(socket.socket()) as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(TegotaeError) as raised:
            on_cluster(address, timeout_s=0.5)
    assert str(raised.value) == (
        f"no Dask scheduler can be reached at '{address}': no answer within 0.5 s"
    )
