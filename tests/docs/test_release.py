"""A release works where it is installed, without extras, and declares what it was tested with."""

import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile

import pytest

from places import ROOT
from tegotae import __version__
from tegotae.api.about import SOFTWARE

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = {
    *("gymnasium", "ziglang", "mujoco", "stable_baselines3", "torch", "tensorboardX", "onnx"),
    *("onnxruntime", "casadi", "pyarrow", "optuna", "distributed", "evosax", "optax"),
}
"""Modules of extras: a plain installation has none of them."""
MISSING = f"""
import runpy, sys

class Missing:
    def find_spec(name, path=None, target=None):
        if name.partition(".")[0] in {sorted(EXTRAS)}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Missing)
"""
"""A program's beginning, after which no extra is there."""
WITHOUT_EXTRAS = f"""{MISSING}
sys.argv[0] = "tegotae"
runpy.run_module("tegotae", run_name="__main__", alter_sys=True)
"""


LOADED = f"""{MISSING}
from tegotae.cli.commands import COMMANDS
from tegotae.cli.program import CommandGroup

def load(entries):
    for entry in entries.values():
        load(entry.commands) if isinstance(entry, CommandGroup) else entry.load()

load(COMMANDS)
import tegotae_robots.c, tegotae_robots.live, tegotae.figures.animation, tegotae.training.run
"""


def test_every_command_begins_without_extras():
    subprocess.run([sys.executable, "-c", LOADED], check=True)


def test_the_version_and_its_date_are_one_in_all_places():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8").replace('"', "")
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert PROJECT["version"] == __version__
    (version,) = re.findall(r"\nversion: (\S+)\n", citation)
    (date,) = re.findall(r"\ndate-released: (\S+)\n", citation)
    latest = re.search(r"^## (\d\S*) - (\S+)$", changes, re.MULTILINE)
    assert latest is not None
    assert (version, date) == (__version__, latest[2]) == (latest[1], date)
    assert date.startswith(SOFTWARE.year)
    notice = f"\nCopyright {SOFTWARE.year} {SOFTWARE.authors[0]}\n"
    assert notice in (ROOT / "LICENSE").read_text(encoding="utf-8")


def test_extras_are_named_with_their_sizes():
    page = (ROOT / "docs" / "getting-started.md").read_text(encoding="utf-8")
    for_users = set(PROJECT["optional-dependencies"]) - {"all", "dev", "docs", "test"}
    assert [name for name in sorted(for_users) if f"| `{name}` | " not in page] == []


@pytest.mark.thorough
def test_both_distributions_have_the_whole_package(built):
    (sdist,), (wheel,) = built.glob("*.tar.gz"), built.glob("*.whl")
    assert sdist.stat().st_size < 8e6
    with tarfile.open(sdist) as archive:
        prefix = f"tegotae-{__version__}/src/"
        sources = {n.removeprefix(prefix) for n in archive.getnames() if n.startswith(prefix)}
    with zipfile.ZipFile(wheel) as archive:
        packed = {
            name
            for name in archive.namelist()
            if name.startswith(("tegotae/", "tegotae_robots/", "lanewise/"))
        }
    listed = subprocess.run(
        ["git", "ls-files", "src"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    tracked = {line.removeprefix("src/") for line in listed.stdout.splitlines()}
    assert "tegotae/py.typed" in tracked
    assert tracked <= sources
    beside = {f"tegotae/systems/zoo/data/{name}.npz" for name in ("calibrated", "paper")}
    assert tracked - packed == beside


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "output"),
    [
        ("simulate zoo:ART-rF-tphif-w8 --duration-s 5 --plot a.png --animate a.gif", "CoT⁻¹"),
        ("export c zoo:V-reflex-w8 --out leg", "leg"),
        ("wiring baseline leg", "pip install 'tegotae[mujoco]'"),
        ("train ART --algorithm snes --out run", "pip install 'tegotae[evosax]'"),
    ],
)
def test_an_installed_wheel_works_without_extras_or_names_the_one(built, tmp_path, words, output):
    (wheel,) = built.glob("*.whl")
    place = tmp_path / "installed"
    zipfile.ZipFile(wheel).extractall(place)  # what pip does, but for the commands
    completed = subprocess.run(
        [sys.executable, "-P", "-c", WITHOUT_EXTRAS, *words.split()],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(place)},
        capture_output=True,
        text=True,
    )
    assert output in completed.stdout + completed.stderr
    assert "Traceback" not in completed.stderr
