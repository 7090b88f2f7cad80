"""Examples are short, run, draw a picture and check their result; the gallery is made of them."""

import re
import runpy
import sys

import matplotlib
import pytest

from pages import DOCS
from places import ROOT, TESTS
from tegotae.measures.hopping import HOPPING

EXAMPLES = ROOT / "examples"
PATHS = sorted(EXAMPLES.rglob("*.py"))
LONGEST = 60
"""Lines of an example."""
HERE = (
    *("hopper", "gain_map", "train_and_evaluate", "own_term", "own_metric", "own_body"),
    *("quadruped_transitions", "generalise", "export_and_replay"),
)
"""Those that need neither extra nor hardware, and run here."""
ON_MUJOCO = {"mujoco_leg": (), "sb3": ("torch",)}
"""Those on a leg of one's own, with what else they need."""
IN_GUIDES = ("own_metric", "own_term", "train_and_evaluate")
"""Those whose calls a page makes that is run, too."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.thorough) if name in IN_GUIDES else name
        for name in (*HERE, *ON_MUJOCO)
    ],
)
def test_an_example_runs_draws_its_picture_and_its_check_holds(name, tmp_path, monkeypatch):
    for module in ("mujoco", *ON_MUJOCO[name]) if name in ON_MUJOCO else ():
        pytest.importorskip(module)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "argv", [f"{name}.py"])
    monkeypatch.setattr(HOPPING, "_registered", dict(HOPPING._registered))
    with matplotlib.rc_context({"savefig.dpi": 100}):
        runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    assert (tmp_path / f"{name}.png").stat().st_size > 5000
    assert "\nassert " in (EXAMPLES / f"{name}.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.stem)
def test_an_example_is_short_and_says_what_it_shows(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= LONGEST
    assert lines[0].startswith('"""')


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.stem)
def test_every_example_is_run_by_the_tests(path):
    name = re.compile(rf"\b{path.stem}\b")
    assert any(name.search(test.read_text(encoding="utf-8")) for test in TESTS.rglob("test_*.py"))


@pytest.mark.parametrize("name", [*HERE, "live"])
def test_the_gallery_shows_the_code_and_the_picture_of_an_example(name):
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    assert f"```{{literalinclude}} ../examples/{name}.py\n" in page
    assert f"```{{image}} _static/gallery/{name}.png\n" in page
    assert (DOCS / "_static" / "gallery" / f"{name}.png").stat().st_size < 150_000
