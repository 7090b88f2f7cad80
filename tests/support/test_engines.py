"""Choice of the engine: native code where it can run, XLA elsewhere, as `engine` reports."""

import re
import warnings
from importlib.metadata import PackageNotFoundError

import jax
import pytest

import tegotae
from refusals import refused
from tegotae import Rollout, Scenario, TegotaeError, Timing
from tegotae._support import engines
from tegotae._support.engines import EngineWarning, selected
from tegotae.systems.recipe import recipe
from tegotae.training.evolution import Evolution
from tegotae.training.run import Run


@pytest.fixture
def llvmlite(monkeypatch):
    """A function that has llvmlite be of another version, or missing (None)."""

    def clear() -> None:
        engines.why_not_native.cache_clear()
        engines._say.cache_clear()

    def be(version: str | None) -> None:
        def installed_version(name: str) -> str:
            assert name == "llvmlite"
            if version is None:
                raise PackageNotFoundError(name)
            return version

        monkeypatch.setattr(engines, "version", installed_version)
        clear()

    yield be
    clear()


def test_native_code_runs_by_default():
    assert selected() == "native"


def test_the_environment_names_the_engine(monkeypatch):
    monkeypatch.setenv("TEGOTAE_ENGINE", "xla")
    assert selected() == "xla"


@pytest.mark.parametrize("name", ["jax_enable_x64", "jax_debug_nans", "jax_debug_infs"])
def test_a_setting_of_jax_that_changes_results_is_refused_before_work(name, one_line_error):
    message = f"{name} is on, and .*; unset {name.upper()}, or"
    jax.config.update(name, True)
    try:
        assert re.search(message, one_line_error("simulate", "paper"))
        for work in (
            lambda: tegotae.load("paper").simulate(),
            lambda: Run(experiment=tegotae.recipe("AR").experiment()),
            lambda: Evolution().start(tegotae.recipe("AR").experiment(), [0]),
        ):
            refused(message, work)
    finally:
        jax.config.update(name, False)


def test_an_unknown_engine_is_refused_in_one_line(monkeypatch, one_line_error):
    monkeypatch.setenv("TEGOTAE_ENGINE", "llvm")
    message = one_line_error("models")
    assert "TEGOTAE_ENGINE is 'llvm'; it must be native or xla" in message


@pytest.mark.parametrize(
    ("version", "reason"),
    [
        (None, "llvmlite is not installed; XLA runs instead"),
        ("0.49.1", "llvmlite is 0.49.1, and native code is tested with 0.50; XLA runs instead"),
    ],
)
def test_without_a_tested_llvmlite_xla_runs_and_that_is_said_once(llvmlite, version, reason):
    llvmlite(version)
    rollout = Rollout(controller=recipe("V-reflex-w8").controller(), timing=Timing(duration_s=0.02))
    with pytest.warns(EngineWarning) as warned:
        assert rollout.run([2.0], Scenario(omega=8.0)).height_m.shape == (1, 1)
    (warning,) = warned
    assert str(warning.message).startswith(reason)
    assert "\n" not in str(warning.message)
    rollout.run([2.0], Scenario(omega=8.0))  # a second warning would be an error


def test_native_code_that_is_asked_for_and_cannot_be_had_is_an_error(llvmlite, monkeypatch):
    llvmlite(None)
    monkeypatch.setenv("TEGOTAE_ENGINE", "native")
    refused("TEGOTAE_ENGINE is native, and llvmlite is not", selected)


def test_on_a_gpu_xla_runs_without_a_word(monkeypatch):
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert selected() == "xla on a GPU"


@pytest.mark.parametrize("made_by", ["native", "native, xla for sort"])
def test_what_an_engine_made_goes_on_with_it_alone(made_by, monkeypatch):
    engines.require_engine(made_by, "here is something", "start again")
    monkeypatch.setenv("TEGOTAE_ENGINE", "xla")
    with pytest.raises(TegotaeError, match=r"^here is something of the engine native") as raised:
        engines.require_engine(made_by, "here is something", "start again")
    assert str(raised.value).endswith("set TEGOTAE_ENGINE=native, or start again")
