"""`tegotae models`: the 218 models of the study and the short laws, as a table or as JSON."""

import json

import pytest

from tegotae.cli import main
from tegotae.systems.recipe import recipe, study_recipes
from tegotae.systems.term_sets import LAWS


@pytest.fixture
def listed(capsys):
    """A function that runs `tegotae models --json` and returns the list."""

    def run(*options: str) -> list[dict]:
        assert main(["models", *options, "--json"]) == 0
        out, err = capsys.readouterr()
        assert err == ""
        return json.loads(out)

    return run


@pytest.fixture
def table(capsys):
    """A function that runs `tegotae models` and returns the table's rows and the last line."""

    def run(*options: str) -> tuple[list[list[str]], str]:
        assert main(["models", *options]) == 0
        *lines, last = capsys.readouterr().out.splitlines()
        rows = [line.split() for line in lines if line.strip() and "─" not in line]
        assert rows[0][0] == "model"
        return rows[1:], last

    return run


def test_table_and_json_name_the_same_models_and_laws_in_the_same_order(listed, table):
    names = [model["name"] for model in listed()]
    rows, last = table()
    laws = [f"{law}-w{omega}" for law in LAWS for omega in (4, 8)]
    assert names == [row[0] for row in rows] == [*study_recipes(), *laws]
    assert (len(set(names)), last) == (230, "218 models, 12 short laws")


def test_a_short_law_is_listed_like_a_model(listed, table):
    assert listed("latch-w4") == [
        {
            "name": "latch-w4",
            "architecture": "latch",
            "learned_terms": [],
            "observation": ["spring_force"],
            "reaction_observation": None,
            "gain_observation": None,
            "actuation": "sector",
            "omega_t_rad_per_s": 4.0,
            "parameters": 5,
        }
    ]
    (clock, _), last = table("clock")
    assert (clock, last) == (["clock-w4", "-", "-", "sector", "4", "2"], "2 short laws")
    assert [law["actuation"] for law in listed("tuned")] == ["both", "both"]
    small = listed("[cl]*-w8", "--budget", "3")
    assert [law["architecture"] for law in small] == ["clock", "load"], "a latch has five numbers"


def test_an_entry_tells_the_models_design(listed):
    assert listed("ARGT-rF-gFv-tphif-w4") == [
        {
            "name": "ARGT-rF-gFv-tphif-w4",
            "architecture": "ARGT",
            "learned_terms": ["A", "R", "G", "T"],
            "observation": ["spring_force", "velocity"],
            "reaction_observation": "F",
            "gain_observation": "Fv",
            "actuation": "tphif",
            "omega_t_rad_per_s": 4.0,
            "parameters": recipe("ARGT-rF-gFv-tphif-w4").controller().n_weights,
        }
    ]
    (vanilla,) = listed("V-sector-w8")
    assert (vanilla["learned_terms"], vanilla["parameters"]) == ([], 1)
    assert (vanilla["reaction_observation"], vanilla["gain_observation"]) == (None, None)
    (single,) = listed("T-F")
    assert (single["architecture"], single["omega_t_rad_per_s"]) == ("T", None)


def test_all_entries_have_the_same_keys_and_respect_the_budget(listed):
    models = listed()
    assert {tuple(model) for model in models} == {tuple(models[0])}
    assert all(1 <= model["parameters"] <= 96 for model in models)
    assert {model["omega_t_rad_per_s"] for model in models} == {4.0, 8.0, None}


@pytest.mark.parametrize(
    ("pattern", "count"),
    [("A*-w4", 54), ("V-*", 6), ("T-F*", 2), ("ART-r?-tphif-w8", 1)],
)
def test_a_pattern_chooses_as_in_a_shell(listed, table, pattern, count):
    assert len(listed(pattern)) == count
    rows, last = table(pattern)
    assert len(rows) == count
    assert last == f"{count} models"


@pytest.mark.parametrize(("architecture", "count"), [("V", 6), ("ART", 12), ("T", 2), ("VG", 12)])
def test_an_architecture_chooses_its_models(listed, architecture, count):
    models = listed(architecture)
    assert len(models) == count
    assert {model["architecture"] for model in models} == {architecture}
    assert recipe(architecture).name in [model["name"] for model in models]


def test_the_budget_is_an_option(listed):
    small = listed("ART", "--budget", "20")
    assert all(13 <= model["parameters"] <= 20 for model in small)


def test_the_trained_controllers_of_one_study_have_the_columns_that_it_measured(listed, capsys):
    assert main(["models", "*@quadruped-c", "--zoo"]) == 0
    heading, _, *rows = capsys.readouterr().out.splitlines()
    assert "CoT⁻¹" in heading
    assert "T0" not in heading
    names = [row["name"] for row in listed("*@quadruped-c", "--zoo")]
    assert [row.split()[0] for row in rows[: len(names)]] == names
