"""Side effects of importing the package: none."""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import tegotae


def fresh(program: str, folder: Path, *flags: str, **environment: str) -> Any:
    """Return the last line that a new Python prints, read as JSON; `folder` is its home and where
    it works."""
    env = {**os.environ, "HOME": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}
    env |= environment
    words = [sys.executable, *flags, "-c", program]
    completed = subprocess.run(words, env=env, cwd=folder, capture_output=True, text=True)
    assert (completed.returncode, completed.stderr) == (0, "")
    return json.loads(completed.stdout.splitlines()[-1])


PLAIN = """
import json, os, signal, sys, warnings
before = dict(os.environ), list(sys.path), signal.getsignal(signal.SIGINT), warnings.filters[:]
import tegotae
assert before == (dict(os.environ), sys.path, signal.getsignal(signal.SIGINT), warnings.filters)
heavy = ("jax", "numpy", "scipy", "matplotlib", "pandas", "gymnasium", "torch", "tyro")
print(json.dumps([name for name in heavy if name in sys.modules]))
"""


def test_importing_it_loads_nothing_and_changes_nothing(tmp_path):
    assert fresh(PLAIN, tmp_path) == []
    assert list(tmp_path.iterdir()) == []


BESIDE_JAX = """
import json, os, sys
import jax
before = dict(os.environ), dict(jax.config.values)
import tegotae
for name in tegotae.__all__:
    getattr(tegotae, name)
assert before == (dict(os.environ), dict(jax.config.values))
print(json.dumps([jax.local_device_count(), "gymnasium" in sys.modules]))
"""


def test_another_programs_jax_stays_as_it_is(tmp_path):
    assert fresh(BESIDE_JAX, tmp_path) == [1, False]
    assert list(tmp_path.iterdir()) == []


BARE = """
import json, sys
EXTRAS = "distributed evosax gymnasium mujoco optax optuna torch".split()

class NoExtra:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in EXTRAS:
            raise ModuleNotFoundError(name, name=name)

sys.meta_path.insert(0, NoExtra())
from tegotae.cli import main
commands = (
    "simulate zoo:ART-rF-tphif-w4/0 --duration-s 2",
    "evaluate paper-reflex --metric hop_rate",
    "conditions",
    "export c zoo:ART-rF-tphif-w4/0 --out robot",
    "train ART --seeds 1 --population 4 --generations 1 --duration-s 6 --settle-s 3",
)
print(json.dumps([main(command.split()) for command in commands]))
"""


LEAST = """
import json, sys

class Least:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("evosax", "llvmlite", "matplotlib", "optax"):
            raise ModuleNotFoundError(name, name=name)

sys.meta_path.insert(0, Least())
from tegotae.cli import main
commands = (
    "simulate zoo:ART-rF-tphif-w4/0 --duration-s 1",
    "evaluate paper-reflex --metric hop_rate",
    "export c zoo:ART-rF-tphif-w4/0 --out robot",
)
print(json.dumps([main(command.split()) for command in commands]))
"""


def test_the_least_installation_simulates_evaluates_and_exports(tmp_path):
    assert fresh(LEAST, tmp_path, TEGOTAE_QUIET="1", TEGOTAE_ENGINE="xla") == [0] * 3


def test_an_installation_without_extras_simulates_measures_exports_and_trains(tmp_path):
    assert fresh(BARE, tmp_path, TEGOTAE_QUIET="1") == [0] * 5


RUN = """
import json, os
{first}
import numpy as np
from tegotae import Rollout, Scenario, Timing
from tegotae.systems.recipe import recipe
before = dict(os.environ)
rollout = Rollout(controller=recipe("V-reflex-w8").controller(), timing=Timing(duration_s=0.1))
height = rollout.run([2.0], Scenario(omega=8.0)).height_m
import jax
assert dict(os.environ) == before
print(json.dumps([jax.local_device_count(), height[-1].tolist()]))
"""
JAX_FIRST = "import jax.numpy as jnp; jnp.ones(3) + 1"


def test_a_rollout_neither_sets_jax_up_nor_minds_who_started_it(tmp_path):
    alone = fresh(RUN.format(first=""), tmp_path, "-W", "error")
    assert fresh(RUN.format(first=JAX_FIRST), tmp_path, "-W", "error") == alone
    assert alone[0] == 1
    assert list(tmp_path.iterdir()) == [], "nothing is kept anywhere"


def test_the_package_has_every_name_that_type_checkers_see():
    stub = Path(tegotae.__file__).with_suffix(".pyi")
    names = {
        alias.asname: node.module
        for node in ast.parse(stub.read_text(encoding="utf-8")).body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert sorted(names) == tegotae.__all__
    for name, home in names.items():
        value = getattr(tegotae, name)
        assert value is getattr(sys.modules[home], name)


def test_the_package_lists_its_public_names_alone():
    assert tegotae.cite is not None
    public = {name for name in dir(tegotae) if not name.startswith("_")}
    assert public == {*tegotae.__all__}


def test_rooms_are_there_without_an_import_of_their_own():
    assert tegotae.parts.__name__ == "tegotae.parts"


@pytest.mark.parametrize("name", ["Enginee", "__wrapped__", "no_such_module"])
def test_a_name_that_is_not_there_is_an_attribute_error(name):
    with pytest.raises(AttributeError, match=f"module 'tegotae' has no attribute '{name}'"):
        getattr(tegotae, name)


def test_a_command_that_is_a_method_is_shown_as_one():
    with pytest.raises(AttributeError, match=r"tegotae\.load\(NAME\)\.simulate is a method"):
        tegotae.simulate  # noqa: B018  # pyright: ignore[reportAttributeAccessIssue]
