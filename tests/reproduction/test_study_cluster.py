"""The study on Dask: the same numbers, whatever becomes of a worker."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
from contextlib import ExitStack, closing, contextmanager, suppress

import pytest

import study_runs
from refusals import refused
from research.reproduction import runner
from research.reproduction.cluster import on_cluster
from research.reproduction.folder import Folder
from research.reproduction.plan import plan
from tegotae._support.errors import TegotaeError

distributed = pytest.importorskip("distributed")


@contextmanager
def cluster(workers: int):
    with distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        dashboard_address=None,
        silence_logs=50,
    ) as scheduler:
        yield scheduler


def when_at_work(cluster, action):
    """A thread that waits until a worker is at work, and then does something with that worker."""

    def watch() -> None:
        action(study_runs.wait_for(lambda: busy(cluster), "a worker at work"))

    thread = threading.Thread(target=watch)
    thread.start()
    return thread


def busy(cluster):
    states = list(cluster.scheduler.workers.values())
    return next((state for state in states if state.processing), None)


@pytest.mark.thorough
def test_a_worker_killed_during_the_run_changes_nothing(smoke_study, tmp_path):
    killed = []
    with cluster(workers=2) as two:
        pids = {nanny.worker_address: nanny.pid for nanny in two.workers.values()}

        def kill(worker) -> None:
            nanny = next(n for n in two.workers.values() if n.worker_address == worker.address)
            killed.append(nanny.pid)
            os.kill(nanny.pid, signal.SIGKILL)

        thread = when_at_work(two, kill)
        assert (
            runner.run_study(plan("smoke"), tmp_path / "study", on_cluster(two.scheduler_address))
            == 3
        )
        thread.join()
    assert len(pids) == 2
    assert len(killed) == 1
    study_runs.assert_same(tmp_path / "study", smoke_study)


def test_a_cluster_of_this_machine_finds_the_same_from_a_plain_shell(smoke_study, tmp_path):
    """Its workers import the program's module before their environment is set."""
    folder = study_runs.copy(smoke_study, tmp_path / "study", "ART", "T")
    scheduler = study_runs.start(folder, "--cluster", "local", programs_of=smoke_study)
    out, err = study_runs.finish(scheduler)
    assert out.startswith("3 records in ")
    assert all(line.startswith("study  ") for line in err.splitlines())
    study_runs.assert_same(folder, smoke_study)


PRELOADED = """
import jax
jax.numpy.zeros(3)  # JAX starts its devices
"""


@contextmanager
def dask_programs(place, *of_the_worker: str):
    """A `dask scheduler` with one `dask worker --no-nanny`, as started by hand: its address."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    dask = [sys.executable, "-m", "dask"]
    scheduler_file = place / "scheduler.json"
    with ExitStack() as programs:

        def start(*words: str) -> None:
            program = subprocess.Popen([*dask, *words], env=environment, stderr=subprocess.DEVNULL)
            programs.enter_context(program)
            programs.callback(program.kill)

        start(
            *("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"),
            *("--dashboard-address", "127.0.0.1:0", "--scheduler-file", str(scheduler_file)),
        )
        study_runs.wait_for(scheduler_file.exists, "a scheduler")
        address = json.loads(scheduler_file.read_text())["address"]
        start(
            *("worker", address, "--no-nanny", "--nthreads", "1", "--no-dashboard"),
            *("--local-directory", str(place), *of_the_worker),
        )
        yield address


@pytest.mark.thorough
def test_workers_started_by_hand_find_the_same(smoke_study, tmp_path):
    folder = study_runs.copy(smoke_study, tmp_path / "study", "V", "T")
    with dask_programs(tmp_path) as address:
        study_runs.finish(study_runs.start(folder, "--cluster", address))
    study_runs.assert_same(folder, smoke_study)


@pytest.mark.thorough
def test_a_worker_whose_jax_was_started_otherwise_refuses_the_work(smoke_study, tmp_path):
    folder = study_runs.copy(smoke_study, tmp_path / "study", "V", "T")
    (tmp_path / "preloaded.py").write_text(PRELOADED)
    with dask_programs(tmp_path, "--preload", str(tmp_path / "preloaded.py")) as address:
        process = study_runs.start(folder, "--cluster", address)
        _, err = process.communicate(timeout=900)
    assert process.returncode == 2
    message = err.splitlines()[-1]
    assert message.startswith(f"tegotae: the worker {socket.gethostname()} (process ")
    assert message.endswith(
        f": start the worker anew; {folder} keeps 2 of 3 models, "
        "the same command continues from there"
    )
    assert "has started JAX already, with 1 cpu; this work needs" in message


def serve() -> None:
    """A cluster that prints its address, and then when it is at work, and waits to be killed."""
    with cluster(workers=1) as scheduler:
        print(scheduler.scheduler_address, flush=True)
        study_runs.wait_for(lambda: busy(scheduler), "a worker at work")
        print("at work", flush=True)
        threading.Event().wait()


@pytest.mark.thorough
def test_a_scheduler_that_goes_away_costs_the_work_in_flight(smoke_study, tmp_path):
    folder = study_runs.copy(smoke_study, tmp_path / "study", "V", "A")
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
            runner.run_study(plan("smoke"), folder, results)
        thread.join()
    assert str(raised.value) == (
        f"the Dask scheduler at {address} went away; {folder} keeps 2 of 3 models, "
        "the same command continues from there"
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
    words = ["reproduction", "run", "--dir", str(tmp_path / "study"), "--cluster", address]
    assert one_line_error(*words) == (
        f"tegotae: no Dask scheduler can be reached at '{address}': Connection refused\n"
    )
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("scheduler", "missing port number in address"),
        ("", "missing port number in address"),
        ("gopher://scheduler:8786", "unknown address scheme 'gopher'"),
    ],
)
def test_what_is_no_address_is_refused(address, reason):
    with pytest.raises(TegotaeError, match=r"no Dask scheduler can be reached at '.*': ") as raised:
        on_cluster(address)
    assert reason in str(raised.value)


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


@pytest.mark.parametrize("words", [b"SSH-2.0-OpenSSH_9.2\r\n" * 9, bytes(4000), b"\xff" * 4000])
def test_something_else_that_answers_is_no_scheduler(words):
    """Their words are taken for numbers of bytes to come, which no memory holds."""

    def answer() -> None:
        while True:
            try:
                talk, _ = listener.accept()
            except OSError:  # closed
                return
            with suppress(OSError):
                talk.sendall(words)

    with closing(socket.socket()) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        threading.Thread(target=answer, daemon=True).start()
        address = f"tcp://127.0.0.1:{listener.getsockname()[1]}"
        with pytest.raises(TegotaeError) as raised:
            on_cluster(address, timeout_s=5.0)
        listener.shutdown(socket.SHUT_RDWR)
    assert str(raised.value) == (
        f"no Dask scheduler can be reached at '{address}': what answers does not speak as one"
    )


def test_workers_that_never_come_are_waited_for_as_long_as_was_said(tmp_path, monkeypatch, capfd):
    monkeypatch.setattr("research.reproduction.cluster._LOOK_S", 0.05)
    with cluster(workers=0) as empty:
        address = empty.scheduler_address
        results = on_cluster(address, patience_s=0.2)
        with pytest.raises(TegotaeError) as raised:
            runner.run_study(plan("smoke"), tmp_path / "study", results)
    assert str(raised.value).startswith(
        f"the Dask scheduler at {address} has had no workers for 0.2 s; {tmp_path / 'study'} keeps "
        "0 of 3 models"
    )
    message = f"the Dask scheduler at {address} has no workers; waiting 0.2 s for some\n"
    assert capfd.readouterr().err.count(message) == 1


def test_a_worker_is_no_scheduler():
    with cluster(workers=1) as scheduler:
        address = next(iter(scheduler.scheduler_info["workers"]))
        refused(r"a Worker answers there$", on_cluster, address)
