"""A robot's episodes are measured by metrics of one contract, the package's own and users'."""

import dataclasses
import math

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

import own_metrics

import tegotae as tg
from refusals import refused
from tegotae import TegotaeError
from tegotae.envs import load_wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.measures.check import check
from tegotae.measures.robots import ROBOTS, RobotEpisode
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.training.environments.experiment import EnvExperiment

WIDTH_RAD = 2.0


@pytest.fixture(scope="module")
def open_loop():
    """A hopper of MuJoCo without feedback, whose only actuator pushes in one sector of its cycle.

    An actuator's largest force is that of the push.
    """
    wiring = dataclasses.replace(load_wiring("hopper"), sector_rad=(3.0, WIDTH_RAD))
    experiment = EnvExperiment.from_recipe(
        recipe("V-sector-w8"),
        EnvSpec(env="hopper"),
        wiring.reading(recipe("V-sector-w8").controller()),
        omega=2.0 * math.pi,
        duration_s=4.0,
    )
    saved = SavedController(experiment.system, np.zeros(1), "open-loop", task=experiment.task)
    return tg.load(saved)


def test_the_time_at_the_limit_of_force_is_that_of_the_push(open_loop):
    table = open_loop.evaluate(metric=["saturated_share"])
    assert list(table.table["saturated_share"]) == pytest.approx(
        [WIDTH_RAD / (2.0 * math.pi)], abs=0.005
    )
    assert "servos at their limit" in repr(table)


def test_evaluate_computes_the_metrics_that_are_named(open_loop):
    table = open_loop.evaluate(metric=["lasted", "own_metrics:largest_action"]).table
    assert {"lasted", "largest_action"} < set(table)
    assert "duty" not in table
    assert table["largest_action"].item() == 4.0


def test_a_metric_of_other_bodies_is_refused(open_loop):
    with pytest.raises(TegotaeError, match="first_apex_m is a metric of hopping; here is robots"):
        open_loop.evaluate(metric=["own_metrics:first_apex_m"])
    nearest = "no metric of robots is called 'lastet'; did you mean lasted"
    refused(nearest, open_loop.evaluate, metric=["lastet"])


@pytest.mark.parametrize("name", ROBOTS.names())
def test_the_metrics_of_robots_keep_the_contract(name):
    check(ROBOTS.find(name))


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"compute": lambda episode: episode.action[:, 0]}, "it must return one number"),
        ({"compute": lambda episode: episode.load}, "raised AttributeError"),
        ({"range": (0.0, 1.0)}, "outside of the range"),
    ],
)
def test_the_check_says_what_is_wrong_with_a_metric_of_robots(changed, says):
    metric = own_metrics.largest_action
    check(metric)
    check(dataclasses.replace(metric, compute=lambda episode: episode["knee_force"].max()))
    refused(says, lambda: check(dataclasses.replace(metric, **changed)))


def test_an_actuator_that_only_pushes_is_not_saturated_at_rest():
    force = np.array([0.0, 0.0, 1.0, 2.0])
    episode = RobotEpisode(
        time_s=np.arange(4.0),
        observation=force[:, None],
        names=("leg_force",),
        action=force[:, None],
        reward=force,
        phase_rad=force[:, None],
        lasted=1.0,
        fitness=0.0,
        step_s=1.0,
        force_limits={"leg_force": (0.0, 2.0)},
    )
    saturated = ROBOTS.find("saturated_share").compute
    assert saturated(episode) == 0.25
    assert saturated(dataclasses.replace(episode, force_limits={"leg_force": (-1.0, 2.0)})) == 0.25
    assert saturated(dataclasses.replace(episode, force_limits={})) is None
