"""The Pythons that are declared are those that are tested."""

import re
import tomllib

import pytest

from places import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DECLARED = re.findall(r"Python :: (3\.\d+)", "\n".join(PROJECT["classifiers"]))


def test_the_oldest_python_that_is_declared_is_the_oldest_allowed():
    assert PROJECT["requires-python"] == f">={DECLARED[0]}"


def test_every_job_of_the_workflow_runs_on_every_declared_python():
    yaml = pytest.importorskip("yaml")
    file = ROOT / ".github" / "workflows" / "test.yml"
    jobs = yaml.safe_load(file.read_text(encoding="utf-8"))["jobs"]
    for name in ("readme", "installed"):
        assert jobs[name]["strategy"]["matrix"]["python"] == DECLARED
    steps = [step.get("run") for step in jobs["readme"]["steps"]]
    assert {"make test", "make reproduce"} <= {*steps}


def test_every_dependency_has_a_lowest_version():
    assert [need for need in PROJECT["dependencies"] if not re.search(r"[>~]=", need)] == []
