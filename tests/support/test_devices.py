"""What is asked of XLA, and where compiled programs are kept: as a user's shell has it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import jaxlib
import pytest

WHOLE_LOOPS = "xla_cpu_small_while_loop_byte_threshold=1000000"


def shell(program: str, **environment: str) -> list:
    """What a fresh Python prints last, as JSON."""
    clean = ("XLA_FLAGS", "TEGOTAE_PLAIN_XLA", "TEGOTAE_CACHE", "JAX_COMPILATION_CACHE_DIR")
    env = {k: v for k, v in os.environ.items() if k not in clean} | {"TEGOTAE_CACHE": "off"}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=env | environment,
        check=True,
        capture_output=True,
        text=True,
    )
    assert done.stderr == ""
    return json.loads(done.stdout.splitlines()[-1])


OPTIONS = """
import json{then}
import tegotae._support.devices as devices
import jax.numpy as jnp
devices.set_up()
assert float(jnp.sum(jnp.ones(3))) == 3.0
print(json.dumps([list(devices.xla_options()), devices.loops_are_kernels()]))
"""
AS_IT_IS = OPTIONS.format(then="")
OTHER_JAXLIB = OPTIONS.format(
    then="; import importlib.metadata as m; v = m.version; "
    "m.version = lambda name: '99.0' if name == 'jaxlib' else v(name)"
)


@pytest.mark.skipif(jaxlib.__version__ != "0.10.2", reason="the options are for jaxlib 0.10.2")
def test_loops_are_kernels_on_a_jaxlib_on_which_that_was_measured():
    options, whole = shell(AS_IT_IS)
    assert whole
    assert WHOLE_LOOPS in options
    assert "xla_cpu_use_multi_output_fusion=true" in options


def test_another_jaxlib_does_without_and_works():
    options, whole = shell(OTHER_JAXLIB)
    assert not whole
    assert options == ["xla_cpu_use_multi_output_fusion=true"]


def test_a_users_own_flags_stand():
    own = "--xla_backend_extra_options=xla_cpu_use_multi_output_fusion=false"
    options, whole = shell(AS_IT_IS, XLA_FLAGS=own)
    assert not whole
    assert "xla_cpu_use_multi_output_fusion=false" in options
    assert "xla_cpu_use_multi_output_fusion=true" not in options
    own = "--xla_cpu_prefer_vector_width=256"
    options, _ = shell(AS_IT_IS, XLA_FLAGS=own)
    assert [o for o in options if "vector" in o] == ["xla_cpu_prefer_vector_width=256"]


def test_plain_xla_is_jax_as_it_comes():
    assert shell(AS_IT_IS, TEGOTAE_PLAIN_XLA="1") == [[], False]


CACHE = """
import json
import jax, jax.numpy as jnp
from tegotae._support.devices import set_up
set_up()
jax.jit(lambda x: jnp.sin(x) + 41.5)(jnp.ones(7))
print(json.dumps([jax.config.jax_compilation_cache_dir]))
"""


def entries(folder: Path) -> set[str]:
    return {path.name for path in folder.rglob("*-cache")}


def test_programs_are_kept_in_the_users_cache_folder(tmp_path):
    (folder,) = shell(CACHE, TEGOTAE_CACHE="", XDG_CACHE_HOME=str(tmp_path), HOME=str(tmp_path))
    assert Path(folder).is_relative_to(tmp_path)
    kept = entries(tmp_path)
    assert kept
    shell(CACHE, TEGOTAE_CACHE="", XDG_CACHE_HOME=str(tmp_path), HOME=str(tmp_path))
    assert entries(tmp_path) == kept, "the second run found all it needed"


def test_the_cache_can_be_elsewhere_or_off(tmp_path):
    (folder,) = shell(CACHE, TEGOTAE_CACHE=str(tmp_path / "mine"))
    assert Path(folder).is_relative_to(tmp_path / "mine")
    assert entries(tmp_path / "mine")
    assert shell(CACHE, TEGOTAE_CACHE="off") == [None]


def test_what_the_user_told_jax_stands(tmp_path):
    own = str(tmp_path / "own")
    assert shell(CACHE, TEGOTAE_CACHE="", JAX_COMPILATION_CACHE_DIR=own) == [own]


def test_a_folder_that_cannot_be_written_to_is_no_error(tmp_path):
    (tmp_path / "file").write_text("in the way")
    assert shell(CACHE, TEGOTAE_CACHE=str(tmp_path / "file")) == [None]


def test_an_entry_cut_short_is_no_error(tmp_path):
    shell(CACHE, TEGOTAE_CACHE=str(tmp_path))
    for path in tmp_path.rglob("*-cache"):
        path.write_bytes(path.read_bytes()[:20])
    shell(CACHE, TEGOTAE_CACHE=str(tmp_path))


@pytest.mark.thorough
def test_processes_may_share_the_cache(tmp_path):
    """Four at a time, from an empty folder, all silent and all right."""
    env = {k: v for k, v in os.environ.items() if k not in ("XLA_FLAGS",)}
    env["TEGOTAE_CACHE"] = str(tmp_path)
    running = [
        subprocess.Popen([sys.executable, "-c", CACHE], env=env, stderr=subprocess.PIPE, text=True)
        for _ in range(4)
    ]
    assert [process.communicate()[1] for process in running] == [""] * 4
    assert [process.returncode for process in running] == [0] * 4
