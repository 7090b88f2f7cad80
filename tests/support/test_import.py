"""What importing the package does to the program that imports it: nothing."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import tegotae
from tegotae._support.compilation_cache import user_folder

CACHE = str(user_folder())
"""Where other tests have compiled these programs, perhaps."""


def fresh(program: str, folder: Path, *flags: str, **environment: str) -> Any:
    """What a new Python prints last, as JSON; `folder` is its home and where it works."""
    ours = ("XLA_FLAGS", "TEGOTAE_PLAIN_XLA", "TEGOTAE_CACHE", "JAX_COMPILATION_CACHE_DIR")
    env = {name: value for name, value in os.environ.items() if name not in ours}
    env |= {"HOME": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}
    env |= environment
    words = [sys.executable, *flags, "-c", program]
    done = subprocess.run(words, env=env, cwd=folder, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout.splitlines()[-1])


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


def test_another_programs_jax_stays_as_it_is_until_something_runs(tmp_path):
    assert fresh(BESIDE_JAX, tmp_path) == [1, False]
    assert list(tmp_path.iterdir()) == []


RUN = """
import json, sys, warnings
{first}
import numpy as np
from tegotae import Engine, Scenario, Timing, build
engine = Engine(controller=build("V-reflex-w8"), timing=Timing(duration_s=0.1))
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    for _ in range(2):
        height = engine.run([2.0], Scenario(omega=8.0)).height_m
import jax
one_each = [str(each.message) for each in told]
print(json.dumps([jax.local_device_count() > 1, one_each, height[-1].tolist()]))
"""
JAX_FIRST = "import jax.numpy as jnp; jnp.ones(3) + 1"


def test_the_first_rollout_sets_what_it_needs_and_keeps_its_programs(tmp_path):
    several, told, height = fresh(RUN.format(first=""), tmp_path)
    assert (several, told) == (True, [])
    assert list((tmp_path / "cache").rglob("*-cache"))
    known = f"import tegotae; tegotae.set_up(); {JAX_FIRST}"
    assert fresh(RUN.format(first=known), tmp_path) == [True, [], height]


def test_where_jax_has_started_already_a_rollout_says_so_once_and_works(tmp_path):
    several, told, height = fresh(RUN.format(first=JAX_FIRST), tmp_path)
    assert not several
    assert "call tegotae.set_up() before the first use of JAX" in "".join(told)
    assert len(told) == 1
    assert 1.1 < height[0] < 1.2
    assert list(tmp_path.iterdir()) == [], "that program's JAX keeps its ways"


FIRST_USES = {
    "a check": "tegotae.check_term(tegotae.build('ART').tegotae.action)",
    "a recording": "import numpy as np; from tegotae.measures.hopping.measured import measure; "
    "t = np.arange(300) / 100; measure(t, 1 + 0.1 * np.cos(9 * t), rest_length_m=1.0)",
    "a start": "from tegotae.training.evolve import start; "
    "from tegotae.training.algorithms import PGPE; start(PGPE(), tegotae.build('ART'), [0])",
    "an environment": "import gymnasium, tegotae.envs; gymnasium.make('tegotae/Hopper-v0').reset()",
}


@pytest.mark.parametrize("use", FIRST_USES)
def test_whatever_computes_first_sets_what_the_engine_needs(use, tmp_path):
    """A rollout after it would warn, and a warning is an error here."""
    if use == "an environment":
        pytest.importorskip("gymnasium")
    program = f"import tegotae; {FIRST_USES[use]}; import jax; print(jax.local_device_count())"
    assert fresh(program, tmp_path, "-W", "error::UserWarning", TEGOTAE_CACHE=CACHE) >= 2


def test_every_public_name_is_where_type_checkers_see_it():
    tree = ast.parse(Path(tegotae.__file__).read_text(encoding="utf-8"))
    seen = {
        alias.name: each.module
        for node in tree.body
        if isinstance(node, ast.If)
        for each in node.body
        if isinstance(each, ast.ImportFrom)
        for alias in each.names
    }
    assert seen == {name: f"tegotae.{home}" for name, home in tegotae._HOME_OF.items()}
    assert sorted(seen) == tegotae.__all__
    assert {*tegotae.__all__, "__version__"} <= set(dir(tegotae))


def test_rooms_are_there_without_an_import_of_their_own():
    assert tegotae.parts.__name__ == "tegotae.parts"


@pytest.mark.parametrize("name", ["Enginee", "__wrapped__", "no_such_module"])
def test_a_name_that_is_not_there_is_an_attribute_error(name):
    with pytest.raises(AttributeError, match=f"module 'tegotae' has no attribute '{name}'"):
        getattr(tegotae, name)
