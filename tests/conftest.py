"""All tests run under JAX's strict promotion rules: no silent change of dtype or rank."""

import functools
import gc
import importlib
import os
import signal
import tempfile
import time
from pathlib import Path

import jax
import pytest
from hypothesis import settings

from tegotae._support import compiled, engines as engines  # which has JAX keep its programs there

# What tests compile is kept for other processes of theirs, apart from what the user's work does.
os.environ[compiled.VARIABLE] = str(Path(tempfile.gettempdir(), f"tegotae-test-code-{os.getuid()}"))
compiled.keep_xla_programs()
jax.config.update("jax_compilation_cache_dir", os.environ["JAX_COMPILATION_CACHE_DIR"])
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
jax.config.update("jax_numpy_dtype_promotion", "strict")
jax.config.update("jax_numpy_rank_promotion", "raise")

# The same examples in every run, and no deadline: the first call of a function compiles it.
settings.register_profile("tegotae", deadline=None, derandomize=True, max_examples=40)
settings.load_profile("tegotae")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Collecting imports everything: a million objects that stay, and no garbage to look for."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(20_000, 20, 20)
        gc.enable()


def _broadcasting(method):
    @functools.wraps(method)
    def call(*args, **kwargs):
        with jax.numpy_rank_promotion("allow"):
            return method(*args, **kwargs)

    return call


# The rules are for this package's code; evosax counts on broadcasting.
_strategy = importlib.import_module("evosax.algorithms.base").EvolutionaryAlgorithm
for _name in ("init", "ask", "tell"):
    setattr(_strategy, _name, _broadcasting(getattr(_strategy, _name)))


@pytest.fixture(autouse=True, scope="module")
def metrics_as_before():
    """What a file's tests register is forgotten after them: several files share a process."""
    from tegotae.measures.gaits.metrics import WALKING
    from tegotae.measures.hopping import HOPPING
    from tegotae.measures.robots import ROBOTS

    catalogues = (HOPPING, WALKING, ROBOTS)
    before = [catalogue.names() for catalogue in catalogues]
    yield
    for catalogue, names in zip(catalogues, before, strict=True):
        for name in set(catalogue.names()).difference(names):
            catalogue.forget(name)


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown():
    """Where a test leaves the process large, give back what was kept of earlier ones."""
    import memory

    memory.give_back_if_large()


@pytest.fixture(scope="session")
def tiny_training(tmp_path_factory) -> Path:
    """The folder of a finished tiny training, to be read only."""
    import tiny

    folder = tmp_path_factory.mktemp("tiny") / "training"
    assert tiny.train(folder) == 0
    return folder


@pytest.fixture(scope="session")
def smoke_study(tmp_path_factory) -> Path:
    """The folder of an undisturbed smoke study, to be read only."""
    import study_runs

    # One for all processes of pytest-xdist.
    place = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        place = place.parent
    return study_runs.undisturbed(place)


@pytest.fixture
def clock(monkeypatch):
    """The clock of everything in this test, on which waiting takes no time."""
    from clocks import Clock

    clock = Clock()
    monkeypatch.setattr(time, "perf_counter", clock.perf_counter)
    monkeypatch.setattr(time, "sleep", clock.sleep)
    return clock


@pytest.fixture
def one_line_error(capsys):
    """A function that runs `tegotae` on unusable input, and returns what it says of it."""
    from programs import main

    def run(*arguments: str) -> str:
        assert main(arguments) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.startswith("tegotae: ")
        assert err.endswith("\n")
        assert len(err.splitlines()) == 1
        return err

    return run


# Started in the background, a shell's children ignore Ctrl-C, and so would theirs, which tests
# interrupt. A handler here is the default in programs that are started from here.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """Show the memory of each process of pytest-xdist."""
    peak = node.workeroutput.get("peak_mib", 0.0)
    print(f"\n{node.gateway.id} had {peak:.0f} MiB of memory at most")


def pytest_sessionfinish(session):
    """Keep what was solved, where that is asked for (`make solutions`)."""
    import memory
    import solutions

    if os.environ.get(solutions.ANEW) == "keep":
        solutions.keep()
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["peak_mib"] = memory.peak_mib()


@pytest.fixture
def study():
    """Import a module of `research`."""
    return lambda name: importlib.import_module(f"research.{name}")


@pytest.fixture(scope="session")
def built(tmp_path_factory) -> Path:
    """A folder with a source distribution and a wheel, built once for all tests of a process."""
    import distributions

    return distributions.build(tmp_path_factory.mktemp("built"))
