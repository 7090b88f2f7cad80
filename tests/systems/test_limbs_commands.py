"""Commands on controllers with several limbs: training, saving, and refusals of what is for one.

The metrics of hopping are those of one leg. Whatever needs them says so before any work.
"""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from places import TESTS
from refusals import refused
from tegotae import Experiment, Rollout, Scenario, TegotaeError, Timing
from tegotae.analysis.maps import map_basin
from tegotae.analysis.orbit import find_orbit
from tegotae.analysis.simulation import simulate
from tegotae.envs.settings import HopperSettings
from tegotae.measures.hopping.gait import GaitSummary
from tegotae.parts.fields import replace
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.registry import imported

FILE = TESTS / "users" / "two_legs.py"
EXPERIMENT = f"{FILE}:experiment"
ONE_LIMB = "is made for bodies of one limb; a Bar has 2"


@pytest.fixture(scope="module")
def experiment() -> Experiment:
    return imported(str(FILE)).experiment


@pytest.fixture(scope="module")
def saved(experiment) -> SavedController:
    weights = np.random.default_rng(0).normal(size=experiment.controller.n_weights)
    return SavedController.from_weights(
        experiment.controller, weights, experiment.omega, experiment.body
    )


@pytest.fixture
def saved_file(saved, tmp_path, monkeypatch) -> str:
    """Its file, in the current folder."""
    monkeypatch.chdir(tmp_path)
    controller_file.save(saved, "legs.json")
    return "legs.json"


# What is kept


def test_a_document_of_the_experiment_is_read_back(experiment):
    document = json.loads(json.dumps(experiment.document))
    assert document["system"]["controller"]["coupling"] == {"kind": "LearnedCoupling"}
    assert document["system"]["release"]["phase_rad"] == [0.0, 2.0]
    assert document["system"]["release"]["initial_pose"] == [["pitch_rad", 0.05]]
    assert Experiment.from_document(document) == experiment


@pytest.mark.thorough
def test_an_episode_of_training_starts_the_limbs_apart(experiment):
    rollout = Rollout(controller=experiment.controller, timing=Timing(duration_s=0.1))
    weights = np.zeros(experiment.controller.n_weights)
    path = rollout.run(weights, experiment.scenario, experiment.body)
    first = path.phase_rad[0, :, 0] - 8.0 * path.time_s[0, 0]
    np.testing.assert_allclose(first, [0.0, 2.0], atol=1e-5)
    assert path.pitch_rad[0, 0] == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"phase_rad": (0.0, 1.0, 2.0)}, "the release has 3 phases, one a limb; the body has 2"),
        ({"phase_rad": (0.0, math.nan)}, "phase_rad is nan"),
        (
            {"initial_pose": (("roll_rad", 0.1),)},
            "Bar has no initial_pose 'roll_rad'; it takes pitch_rad",
        ),
        ({"initial_pose": (("pitch_rad", math.inf),)}, "pitch_rad is inf"),
    ],
)
def test_a_start_that_the_body_cannot_take_is_refused(experiment, changed, message):
    refused(message, replace, experiment, changed)


# What is for one limb


@pytest.mark.parametrize(
    "words",
    [
        ["reproduction", "run", "--dir", "new", "--models", "", "--experiments", EXPERIMENT],
        ["train", EXPERIMENT, "--algorithm", "sac", "--out", "new"],
    ],
    ids=lambda words: words[0],
)
def test_what_measures_hopping_is_refused_before_any_work(saved_file, words, one_line_error):
    assert ONE_LIMB in one_line_error(*words)
    assert [path.name for path in Path().iterdir()] == [saved_file]


@pytest.mark.parametrize("figure", ["surface", "phase-response", "poincare"])
def test_figures_of_a_hopper_say_for_what_they_are(saved_file, figure, one_line_error):
    message = one_line_error("figure", figure, saved_file, "--out", "x.png")
    assert "legs walks on several legs, and this figure is of one leg" in message


def test_the_optimum_says_it_too(saved_file, one_line_error):
    words = ["reproduction", "optimum", "--controller", saved_file, "--out", "x.png"]
    assert "another body than the paper's hopper" in one_line_error(*words)


@pytest.mark.parametrize(
    "analysis",
    [
        find_orbit,
        lambda saved: map_basin(saved, np.array([1.2]), np.array([0.0])),
        lambda saved: HopperSettings(body=saved.body),
        lambda saved: simulate(saved.system, saved.weights),
    ],
    ids=["orbit", "basin", "environment", "simulation"],
)
def test_from_python_one_line_says_so(saved, analysis):
    refused(ONE_LIMB, analysis, saved)


def test_metrics_of_a_rollout_are_refused_while_it_is_compiled(saved):
    rollout = Rollout(
        controller=saved.controller, timing=Timing(duration_s=1.0), summary=GaitSummary()
    )
    with pytest.raises(TegotaeError, match="bodies of one limb; this recording has 2"):
        rollout.run(saved.weights, Scenario(8.0), saved.body)


# Bodies that do not fit


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["evaluate", "V-reflex-w8", "--body", f"{FILE}:Bar"], "drives 1 limbs, and a Bar has 2"),
        (["train", "ART", "--body", f"{FILE}:Bar"], "drives 1 limbs, and a Bar has 2"),
        (
            ["evaluate", "legs.json", "--flight-damping-ns-per-m", "0.1"],
            "is called '--flight",
        ),
        (
            ["train", EXPERIMENT, "--mass-kg", "0.5"],
            "as a leg of this bar, this hopper cannot hop: its actuator pushes with 4 N at most",
        ),
    ],
)
def test_a_body_that_does_not_fit_is_told_in_one_line(saved_file, words, message, one_line_error):
    assert message in one_line_error(*words)
    assert [path.name for path in Path().iterdir()] == [saved_file]
