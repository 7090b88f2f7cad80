"""Tegotae: learned feedback in central pattern generators, a thousand rollouts at a time."""

from tegotae import _start

_start.prepare()

from tegotae import compilation_cache as _compilation_cache  # noqa: E402
from tegotae import devices as _devices  # noqa: E402

_devices.use_all_cores()
_compilation_cache.use_cache()

from importlib.metadata import PackageNotFoundError, version  # noqa: E402
from importlib.util import find_spec  # noqa: E402

from tegotae.bodies import Body, Hopper  # noqa: E402
from tegotae.checks import (  # noqa: E402
    check_body,
    check_controller,
    check_oscillator,
    check_term,
)
from tegotae.controller import Controller, Tegotae  # noqa: E402
from tegotae.errors import TegotaeError  # noqa: E402
from tegotae.experiment import Experiment  # noqa: E402
from tegotae.models import Model, all_models, build, find  # noqa: E402
from tegotae.registry import register  # noqa: E402
from tegotae.rollout import Engine, Scenario, Timing, Trajectory  # noqa: E402

if find_spec("gymnasium") is not None:
    from tegotae import envs as _envs  # noqa: F401 - registers the environments

try:
    __version__ = version("tegotae")
except PackageNotFoundError:  # a source tree that is not installed
    __version__ = "0+unknown"

__all__ = [
    "Body",
    "Controller",
    "Engine",
    "Experiment",
    "Hopper",
    "Model",
    "Scenario",
    "Tegotae",
    "TegotaeError",
    "Timing",
    "Trajectory",
    "all_models",
    "build",
    "check_body",
    "check_controller",
    "check_oscillator",
    "check_term",
    "find",
    "register",
]
