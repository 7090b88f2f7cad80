"""The labs run from top to bottom, show tables and figures, and fold a solution away each time."""

import re
import zipfile

import pytest

import tegotae
from pages import DOCS
from places import ROOT

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

LABS = sorted((ROOT / "examples" / "labs").glob("*.ipynb"))
NEEDS = {"a-leg-of-your-own": "mujoco"}
"""Extras that a lab needs."""
MINUTES = 90
MOST_BYTES = 1_500_000

labs = pytest.mark.parametrize("path", LABS, ids=lambda path: path.stem)


def read(path):
    return nbformat.read(path, as_version=4)


def tagged(notebook, tag):
    return [cell for cell in notebook.cells if tag in cell.metadata.get("tags", ())]


def printed_text(notebook) -> str:
    """All that the cells print or show as text, and their sources."""
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    outputs = [x for cell in cells for x in cell.outputs]
    texts = [x.get("text", "") or x.get("data", {}).get("text/plain", "") for x in outputs]
    return "\n".join([*texts, *(cell.source for cell in cells)])


@labs
def test_a_lab_is_kept_with_its_outputs_and_is_small(path):
    code = [cell for cell in read(path).cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert path.stat().st_size < MOST_BYTES


@labs
def test_the_outputs_that_a_lab_keeps_show_no_progress(path):
    outputs = [x for cell in read(path).cells for x in cell.get("outputs", ())]
    shown = [x["data"].get("text/plain", "") for x in outputs if x.output_type == "display_data"]
    assert [text for text in shown if re.search(r"\b\d+/\d+\b", text)] == []


@labs
def test_the_sections_of_a_lab_are_ninety_minutes(path):
    text = "\n".join(cell.source for cell in read(path).cells if cell.cell_type == "markdown")
    headed = [int(x) for x in re.findall(r"^## \d.*\((\d+) min\)$", text, re.M)]
    planned = [int(x) for x in re.findall(r"^\| \d\. .* \| (\d+) \|$", text, re.M)]
    assert headed == planned
    assert sum(headed) == MINUTES


@labs
def test_every_exercise_has_a_folded_solution_below_it(path):
    notebook = read(path)
    numbers = re.findall(r"\*\*Exercise (\d+)\.\*\*", "\n".join(x.source for x in notebook.cells))
    tags = [cell.metadata.get("tags", [""])[0] for cell in notebook.cells]
    order = [tag for tag in tags if tag in ("exercise", "solution")]
    assert order == ["exercise", "solution"] * len(numbers)
    assert 5 <= len(numbers) <= 8
    for cell in tagged(notebook, "hide-cell"):
        assert cell.metadata["jupyter"] == {"outputs_hidden": True, "source_hidden": True}
        assert cell.outputs


@labs
def test_every_question_has_a_folded_answer_with_numbers_that_cells_print(path):
    notebook = read(path)
    texts = [cell.source for cell in notebook.cells if cell.cell_type == "markdown"]
    answers = re.findall(r"<details><summary>Answer</summary>(.*?)</details>", "".join(texts), re.S)
    assert len(answers) >= "".join(texts).count("**Question.**") > 0
    printed = printed_text(notebook)
    assert [x for a in answers for x in re.findall(r"\d+\.\d+", a) if x not in printed] == []


@labs
def test_the_links_of_a_lab_lead_somewhere(path):
    text = "\n".join(cell.source for cell in read(path).cells if cell.cell_type == "markdown")
    targets = re.findall(r"\]\(([^)#:]+)\)", text)
    assert [target for target in targets if not (path.parent / target).exists()] == []
    assert f"labs/{path.name}" in (DOCS / "labs.md").read_text(encoding="utf-8")


@labs
def test_a_lab_begins_with_the_installation_of_the_wheel(path):
    first = next(cell.source for cell in read(path).cells if cell.cell_type == "code")
    extra = f"[{NEEDS[path.stem]}]" if path.stem in NEEDS else ""
    wheel = f"tegotae-{tegotae.__version__}-py3-none-any.whl{extra}"
    assert re.search(r"^# %pip install --quiet (.*)$", first, re.M)[1].strip('"') == wheel


@pytest.mark.thorough
@labs
def test_a_lab_runs_from_the_wheel_alone_and_shows_tables_and_figures(
    path, tmp_path, tmp_path_factory, built, monkeypatch
):
    if path.stem in NEEDS:
        pytest.importorskip(NEEDS[path.stem])
    (wheel,) = built.glob("*.whl")
    place = tmp_path_factory.mktemp("installed")
    zipfile.ZipFile(wheel).extractall(place)
    monkeypatch.setenv("PYTHONPATH", str(place))
    notebook = read(path)
    notebook.cells.append(nbformat.v4.new_code_cell("print(tg.__file__)"))
    where = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3", resources=where).execute()
    (shown,) = notebook.cells.pop().outputs
    assert shown.text.startswith(str(place))
    outputs = [x for cell in notebook.cells for x in cell.get("outputs", ())]
    kinds = [set(x.get("data", ())) for x in outputs]
    assert any("<table" in x.get("data", {}).get("text/html", "") for x in outputs)
    drawn = re.compile(r"^plt\.show\(\)$|\.plot\(\)$", re.M)
    plots = [x for x in notebook.cells if x.cell_type == "code" and drawn.search(x.source)]
    assert plots
    for cell in plots:
        assert ["image/png" in x.get("data", ()) for x in cell.outputs].count(True) == 1
    for cell in notebook.cells:  # no bar that draws itself anew a thousand times
        assert len(cell.get("outputs", ())) < 12
    assert sum("image/png" in kind for kind in kinds) == len(plots)
