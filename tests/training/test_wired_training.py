"""Training on anyone's environment: the same runs, files and ends, whatever goes wrong in it."""

import contextlib
import dataclasses
import json
import math
from pathlib import Path

import jax
import numpy as np
import pandas as pd
import pytest

pytest.importorskip("gymnasium")

from refusals import refused
from tegotae import TegotaeError, register
from tegotae.analysis.generalisation.disturbances import disturbances_named
from tegotae.analysis.generalisation.on_environment import (
    EnvironmentUnderTest,
    _PerturbedPilot,
)
from tegotae.analysis.generalisation.run import measure_retention
from tegotae.api.trained import TrainedControllers, advice
from tegotae.cli import main
from tegotae.envs import Limb, TegotaeWrapper, Wiring, load_wiring, save_wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.measures.objectives.evaluator import Generation
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.systems import controller_file
from tegotae.systems.controller_file import ControllerSet, SavedController
from tegotae.systems.recipe import recipe
from tegotae.training.algorithms import PGPE, OpenES
from tegotae.training.curves import read_curves
from tegotae.training.environments.evaluator import SampleWarning, WorkerPool
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import EpisodeBatch, Hopping, Return, UserObjective
from tegotae.training.environments.rollouts import EnvRollouts
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train
from wired_experiment import ENV, HERE, WIRING, experiment

GENERATIONS = 3
ALL = Generation.alike()


ALGORITHM = PGPE(population=4)


def run_of(generations: int = GENERATIONS, workers: int = 0, algorithm=ALGORITHM, **changes) -> Run:
    """A small training in this process."""
    return Run(
        **{
            "experiment": experiment(),
            "seeds": (0, 1),
            "learner": Evolution(
                algorithm=algorithm, stopping=Stopping.after(generations), workers=workers
            ),
            **changes,
        }
    )


def learned(folder: Path) -> list:
    files = sorted(folder.glob("*-seed*.json"))
    weights = [controller_file.load(file).weights.tolist() for file in files]
    return [weights, (folder / "curves.csv").read_text()]


def test_the_frequency_is_the_one_given_or_the_wirings_or_else_the_models():
    wired = dataclasses.replace(WIRING, omega=9.0)
    assert experiment(wiring=wired, omega=7.0).omega == 7.0
    assert experiment(wiring=wired).omega == 9.0
    assert experiment().omega == 8.0


@pytest.mark.parametrize("omega", [math.nan, -4.0, 1e9])
@pytest.mark.parametrize("settings", [None, 8.0])
def test_a_wiring_whose_frequency_is_none_is_not_trained(omega, settings):
    with pytest.raises(TegotaeError, match="the wiring's omega is "):
        experiment(wiring=dataclasses.replace(WIRING, omega=omega), omega=settings)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trained")
    return folder, train(run_of(), folder)


# The same runs and files as on the hopper.


def test_a_training_leaves_controllers_curves_and_an_account_of_itself(trained):
    folder, paths = trained
    assert [path.name for path in paths] == [
        "AR-rF-reflex-w8-seed0.json",
        "AR-rF-reflex-w8-seed1.json",
    ]
    assert {p.name for p in folder.iterdir()} >= {"run.json", "curves.csv", "checkpoint.npz"}
    saved = controller_file.load(paths[0])
    assert saved.training["generations"] == GENERATIONS
    assert saved.task is not None
    assert (saved.task.env, saved.task.settings) == (ENV, {})
    assert saved.system.body.known_scales == {"spring_force": 1.0, "feedback": 3.0}
    document = json.loads((folder / "run.json").read_text())["configuration"]
    assert document["experiment"]["objective"] == {"kind": "Return"}


def test_the_best_fitness_is_that_of_the_kept_weights_and_the_return_of_their_episode(trained):
    _, paths = trained
    saved = controller_file.load(paths[0])
    with experiment().evaluator(0) as evaluator:
        verdict = evaluator.evaluate(saved.weights[None, None], ALL)
    assert verdict.fitness[0, 0] == pytest.approx(saved.training["best_fitness"], abs=1e-4)
    assert np.isnan(verdict.cot_inverse).all()
    env = TegotaeWrapper(experiment().spec.make(), Wiring.from_controller(paths[0]))
    env.reset()
    total, over = 0.0, False
    while not over:
        _, reward, _, over, _ = env.step(np.zeros(1, np.float32))
        total += reward
    assert total == pytest.approx(saved.training["best_fitness"], abs=1e-3)


@pytest.mark.parametrize("generation", [1, 2])
def test_an_interrupted_training_goes_on_and_ends_in_the_same_numbers(
    trained, tmp_path, generation
):
    def stop(step):
        finished = step.done
        if finished == generation:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(run_of(), tmp_path, on_step=stop)
    train(run_of(), tmp_path)
    assert learned(tmp_path) == learned(trained[0])


def test_a_folder_of_another_wiring_is_refused(trained):
    rescaled = dataclasses.replace(WIRING, scales={"spring_force": 2.0, "feedback": 3.0})
    with pytest.raises(TegotaeError, match=r"differs in .*wiring"):
        train(run_of(experiment=experiment(wiring=rescaled)), trained[0])


def test_a_folder_whose_environment_or_fitness_was_rewritten_since_is_refused(tmp_path):
    ours = tmp_path / "rewritten_env.py"
    ours.write_text((HERE / "wired_env.py").read_text())

    def run() -> Run:
        task = experiment("V-reflex-w8", budget=96, env=f"{ours}:Scales")
        return run_of(
            experiment=dataclasses.replace(task, objective=UserObjective(f"{ours}:pushes"))
        )

    train(run(), tmp_path / "out")
    train(run(), tmp_path / "out")
    ours.write_text(ours.read_text() + "STEPS = 30\n")
    with pytest.raises(TegotaeError, match="differs in code of environment, code of fitness"):
        train(run(), tmp_path / "out")


@pytest.mark.thorough
def test_other_evolution_strategies_learn_there(tmp_path):
    with jax.numpy_dtype_promotion("standard"):  # which evosax counts on
        (path,) = train(run_of(1, algorithm=OpenES(population=4), seeds=(0,)), tmp_path)
    assert math.isfinite(controller_file.load(path).training["best_fitness"])


def test_the_gain_of_a_vanilla_model_is_searched_for(tmp_path):
    task = experiment("V-reflex-w8", budget=96)
    (path,) = train(run_of(experiment=task), tmp_path)
    saved = controller_file.load(path)
    assert saved.training["ended"] == "search"
    with task.evaluator(0) as evaluator:
        fitness = evaluator.evaluate(task.gains[None, :, None], ALL).fitness[0]
    assert saved.weights[0] == pytest.approx(task.gains[np.argmax(fitness)])
    # Both ends of the grid are tried, and the best is worth more than no feedback at all.
    assert fitness.max() > fitness[0]


def test_a_controller_of_another_simulator_is_not_explained_and_the_error_names_what_studies_it(
    trained, one_line_error
):
    _, (path, *_) = trained
    message = one_line_error("explain", str(path))
    assert "runs in another simulator" in message
    assert "tegotae simulate --csv records its senses, phases and commands there" in message


def test_a_figure_of_efficiency_says_where_none_was_measured(trained, one_line_error, tmp_path):
    words = ("figure", "learning-curves", str(trained[0]), "--out", str(tmp_path / "curves.png"))
    message = one_line_error(*words, "--of", "cot_inverse")
    assert "measured no CoT⁻¹" in message
    assert "damaged" not in message
    assert "--of fitness" in message


def test_learning_curves_are_of_the_fitness_where_that_was_trained(trained, tmp_path):
    picture = tmp_path / "curves.png"
    assert main(["figure", "learning-curves", str(trained[0]), "--out", str(picture)]) == 0
    drawn = read_curves([tmp_path / "curves.csv"], None)
    pd.testing.assert_frame_equal(drawn, read_curves([trained[0]], "fitness"), rtol=1e-6)


def test_a_training_that_gains_nothing_says_what_to_try(trained):
    folder, files = trained
    answer = TrainedControllers.from_files("AR", folder, tuple(files), "generation")
    assert advice(answer, tolerance=-1.0) == []
    (message,) = advice(answer, tolerance=1e9)
    assert message.startswith("Nothing was learned")
    assert "tegotae wiring baseline" in message


# By what is judged.


def test_height_and_work_make_a_hopping_fitness_as_on_the_engine():
    wiring = dataclasses.replace(WIRING, height="height", work="work", rest_length_m=1.0)
    task = experiment("V-reflex-w8", budget=96, wiring=wiring, duration_s=24.0)
    assert task.objective == Hopping(settle_s=12.0)
    with pytest.raises(TegotaeError, match="the wiring does not say height"):
        dataclasses.replace(experiment(), objective=Hopping(settle_s=0.1)).check()


def test_positive_and_net_work_count_where_they_are_measured_and_are_asked_for_otherwise():
    wiring = dataclasses.replace(WIRING, height="height", work="work", rest_length_m=1.0)
    task = experiment("V-reflex-w8", budget=96, wiring=wiring, duration_s=24.0)
    positive = dataclasses.replace(task, objective=Hopping(settle_s=12.0, work="positive"))
    refused("the wiring does not say work_positive, the observ", positive.check)
    refused("work is 'gross'; it must be one of absolute", Hopping, work="gross")
    batch = hops(absolute=2.0, positive=1.5)
    wired = dataclasses.replace(task.wiring, work_positive="positive")
    by = {
        name: Hopping(settle_s=2.0, work=name).score(batch, wired).cot_inverse[0]
        for name in ("absolute", "positive")
    }
    assert by["positive"] == pytest.approx(by["absolute"] * 2.0 / 1.5, rel=1e-5)
    with pytest.raises(TegotaeError, match="the wiring does not say work_net, the observation"):
        Hopping(settle_s=2.0, work="net").score(batch, wired)


def hops(**power_w) -> EpisodeBatch:
    """Eight seconds of hops whose work rises steadily by each definition."""
    time = 0.02 * np.arange(1, 401)
    height = 1.0 + 0.2 * np.sin(8.0 * time)
    entries = [height, power_w["absolute"] * time, power_w["positive"] * time]
    return EpisodeBatch(
        step_s=0.02,
        names=("height", "work", "positive"),
        observation=np.stack(entries, axis=1)[:, None],
        action=np.zeros((0, 1, 1)),
        reward=np.zeros((400, 1)),
        phase_rad=np.zeros((0, 1, 1)),
        ended=np.array([400]),
        steps=400,
        sound=np.ones(1, bool),
        completed=np.ones(1, bool),
    )


def test_generations_draw_starts_that_their_candidates_share_and_the_centre_has_its_own_set():
    pytest.importorskip("mujoco")
    spec = EnvSpec(env="leg", settings=(("noise", 0.02),))
    wiring = dataclasses.replace(
        load_wiring("leg").reading(recipe("V").controller()), omega=8.0, weights=None
    )
    task = EnvExperiment(
        name="varied", spec=spec, wiring=wiring, objective=Return(), duration_s=0.1, seed=3
    )
    varied = dataclasses.replace(task, evaluation_episodes=2)
    candidates = np.ones((2, 3, 1))  # two samples and the centre, of two seeds
    mask = np.array([True, True])
    with varied.evaluator(0) as evaluator:
        first, second, again = (
            evaluator.evaluate(candidates, Generation((5, 6), mask, number)).fitness
            for number in (0, 1, 0)
        )
        alone = evaluator.evaluate(candidates[:1], Generation.alike()).fitness
    assert (first[:, 0] == first[:, 1]).all()
    assert len({first[0, 0], first[1, 0], second[0, 0], second[1, 0]}) == 4
    assert (again == first).all()
    assert set(np.concatenate([first[:, 2], second[:, 2], alone[0]])) == {first[0, 2]}
    saved = SavedController(varied.system, np.ones(1), "varied", task=varied.task)
    assert EnvExperiment.from_controller(saved).evaluation_episodes == 2
    with task.evaluator(0) as evaluator:  # all of one start
        every = evaluator.evaluate(candidates, Generation((5, 6), mask, 1)).fitness
    assert len(set(every.ravel())) == 1
    with pytest.raises(TegotaeError, match="has 3 episodes and a candidate 2"):
        dataclasses.replace(task, episodes=2, evaluation_episodes=3)
    still = dataclasses.replace(varied, spec=EnvSpec(env="leg"))
    refused("the 2 episodes on leg would be alike", still.check)


def test_a_function_of_ones_own_is_asked_about_episodes_that_were_played_alone():
    task = dataclasses.replace(
        experiment("V-reflex-w8", budget=96),
        objective=UserObjective(f"{HERE / 'wired_env.py'}:last_push"),
    )
    rollouts = EnvRollouts(task, 3)
    trials = rollouts.try_out(np.array([[8.0], [8.0]]), troubles=["", "it died"])
    assert trials.fitness[0] > 0.0  # the second is left out, and the third lane is spare
    absent = EnvSpec(env=ENV, settings=(("fail", "reset"),))
    absent = dataclasses.replace(task, spec=absent, seed=1)
    with (
        absent.evaluator(0) as evaluator,
        pytest.warns(SampleWarning, match="nobody is at home"),
        pytest.raises(TegotaeError, match="fails with every sample"),
    ):
        evaluator.evaluate(np.zeros((1, 1, 1)), ALL)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        ("text", r"text returned 'much'; it must return one number"),
        ("divides", "divides failed on an episode of 40 steps: ZeroDivisionError"),
        ("of_no_entry", "no entry of the observation is called 'lod'; did you mean load"),
    ],
)
def test_what_goes_wrong_in_a_function_of_ones_own_is_said_of_the_function(function, message):
    task = dataclasses.replace(
        experiment("V-reflex-w8", budget=96),
        objective=UserObjective(f"{HERE / 'wired_env.py'}:{function}"),
    )
    with task.evaluator(0) as evaluator, pytest.raises(TegotaeError, match=message) as refusal:
        evaluator.evaluate(np.zeros((1, 1, 1)), ALL)
    assert "\n" not in str(refusal.value)


def test_a_fitness_that_is_no_number_for_any_candidate_ends_the_training():
    task = dataclasses.replace(
        experiment("V-reflex-w8", budget=96),
        objective=UserObjective(f"{HERE / 'wired_env.py'}:undefined"),
    )
    with (
        task.evaluator(0) as evaluator,
        pytest.warns(SampleWarning, match="its fitness was not finite"),
        pytest.raises(TegotaeError, match="every sample: its fitness was not finite"),
    ):
        evaluator.evaluate(np.zeros((1, 1, 1)), ALL)


# What goes wrong.

LAZY, BUSY = 0.0, 8.0


@pytest.mark.parametrize(
    ("fail", "message"),
    [
        ("raise", "it raised RuntimeError: the motor is on fire"),
        ("leave", "it raised SystemExit: it ends the program"),
        ("nan", "its observation was not finite"),
        ("pay", "its reward was inf"),
        ("shape", r"its observation has shape \(2,\); its space said \(3,\)"),
    ],
)
def test_a_sample_whose_environment_fails_is_the_worst_and_the_others_are_as_without_it(
    fail, message
):
    task = experiment("V-reflex-w8", budget=96, made={"fail": fail})
    with (
        task.evaluator(0) as evaluator,
        pytest.warns(SampleWarning, match=f"{message}; 1 of 3 samples"),
    ):
        verdict = evaluator.evaluate(np.array([[[LAZY], [BUSY], [LAZY]]]), ALL)
    assert verdict.failed.tolist() == [[False, True, False]]
    assert verdict.fitness[0, 1] == FAILED_FITNESS
    assert verdict.fitness[0, 0] == verdict.fitness[0, 2] == 0.0


def test_an_episode_that_ends_at_once_is_marked():
    ends = f"{HERE / 'wired_env.py'}:AtOnce"
    task = experiment("V-both-w8", budget=96, env=ends)
    phase = dataclasses.replace(WIRING.limbs[0], phase_rad=1.8 * math.pi)
    task = dataclasses.replace(task, wiring=dataclasses.replace(task.wiring, limbs=[phase]))
    message = "fails with every sample: it ended at its first step"
    with (
        task.evaluator(0) as evaluator,
        pytest.warns(SampleWarning, match="it ended at its first step"),
        pytest.raises(TegotaeError, match=message),
    ):
        evaluator.evaluate(np.array([[[LAZY]]]), ALL)


@pytest.mark.thorough
def test_of_an_environment_that_dies_or_hangs_in_a_worker_one_sample_is_lost():
    weights = np.array([[LAZY], [BUSY], [LAZY]])
    for fail, message in (
        ("exit", r"it ended its process \(status 3\)"),
        ("hang", "a step of it took longer than 4 s"),
    ):
        task = experiment("V-reflex-w8", budget=96, made={"fail": fail}, limit_s=4.0)
        with contextlib.closing(WorkerPool(task, 1, 3)) as pool:
            trials = pool.try_out(weights, np.zeros((3, 1), int))
        assert trials.failed.tolist() == [False, True, False]
        assert trials.fitness.tolist() == [0.0, FAILED_FITNESS, 0.0]
        assert trials.troubles[0] == trials.troubles[2] == ""
        assert message.split("\\")[0].split("(")[0].strip() in (trials.troubles[1])


# What is refused before anything is tried.


@pytest.mark.parametrize(
    ("env", "message"),
    [
        ("NoSuch-v0", "no environment is called 'NoSuch-v0'"),
        ("nowhere.py:make", r"there is no file nowhere\.py"),
        (f"{HERE / 'wired_env.py'}:nothing", "made a int; it must make a Gymnasium environment"),
        ("nowhere.xml", r"there is no file nowhere\.xml"),
    ],
)
def test_an_environment_that_cannot_be_made_is_refused(env, message):
    refused(message, lambda: experiment(env=env).check())


def test_a_wiring_that_lacks_something_is_refused_with_all_that_it_lacks():
    limb = Limb(senses={"spring_force": "lod"}, drives="knee")
    with pytest.raises(TegotaeError, match=r"did you mean load.*; limb 0: no action"):
        experiment(wiring=Wiring(limbs=[limb])).check()
    refused("has no oscillator", experiment, "T", budget=96)


def test_a_saved_controllers_body_cannot_be_simulated_here_and_says_so(trained):
    saved = controller_file.load(trained[1][0])
    refused("its body is not here; use Wiring", lambda: saved.body.check_release(1.2))


def test_what_the_wiring_does_not_say_is_not_known_of_the_limbs(tmp_path):
    task = experiment(wiring=dataclasses.replace(WIRING, scales={}))
    assert task.system.body.scales == (None,)
    assert task.system.body.rest_length_m is task.system.body.feedback_scale is None
    saved = SavedController(
        task.system, np.zeros(task.controller.n_weights), task.name, task=task.task
    )
    controller_file.save(saved, tmp_path / "limbs.json")
    text = json.loads((tmp_path / "limbs.json").read_text())
    assert text["system"].keys() == {"controller", "body", "omega"}
    again = controller_file.load(tmp_path / "limbs.json")
    assert again.system.body == task.system.body
    assert Wiring.from_controller(tmp_path / "limbs.json").scales == {}


def test_a_file_says_in_which_experiment_its_controller_was_trained(trained):
    saved = controller_file.load(trained[1][0])
    assert EnvExperiment.from_controller(saved).document == experiment().document
    with pytest.raises(TegotaeError, match="was not trained on an environment"):
        EnvExperiment.from_controller(dataclasses.replace(saved, task=None))


def test_a_task_that_no_file_can_have_is_refused(trained, tmp_path):
    document = json.loads(trained[1][0].read_text())
    document["task"]["wiring"]["limbs"][0]["drives"] = 3
    (tmp_path / "edited.json").write_text(json.dumps(document))
    with pytest.raises(TegotaeError, match=r"task\.wiring\.limbs\[0\]\.drives is 3"):
        controller_file.load(tmp_path / "edited.json")


# From the command line.


def test_the_command_trains_and_the_same_command_goes_on(tmp_path, capsys):
    wiring = tmp_path / "scales.toml"
    save_wiring(WIRING, wiring)
    words = ["train", "AR", "--env", ENV, "--wiring", str(wiring), "--budget", "12"]
    words += ["--duration-s", "0.8", "--workers", "0", "--seeds", "2", "--population", "4"]
    words += ["--algorithm", "pgpe", "--out", str(tmp_path / "out"), "--fitness", "return"]
    assert main([*words, "--generations", "1"]) == 0
    assert main([*words, "--generations", "2"]) == 0
    assert "AR-rF-reflex-w8-seed1.json" in capsys.readouterr().out
    assert len((tmp_path / "out" / "curves.csv").read_text().splitlines()) == 1 + 2 * 2


# What it bears outside of its training.


def on_scales(**wired) -> EnvironmentUnderTest:
    """A feedback that pushes the scales of a Gymnasium environment, of which this is observed."""
    task = experiment("V-sector-w8", wiring=dataclasses.replace(WIRING, omega=8.0, **wired))
    register(ENV.rpartition(":")[0])
    runs = ControllerSet("V", task.system, np.array([[0.5]]), ("0",), task=task.task)
    return EnvironmentUnderTest(runs)


def test_a_gymnasium_environment_is_tried_under_other_senses_actuators_and_frequencies():
    tested = on_scales(height="height", work="work", rest_length_m=1.0)
    conditions = disturbances_named(
        ["delay=0.02", "noise=0.1", "omega=1.1", "lag=0.02", "strength=0.9", "mass=1.2"]
    )
    got = measure_retention(tested, conditions)
    assert got.left_out == {"mass": "a Gymnasium environment has no mass_kg"}
    assert got.table["had"].all()
    assert set(got.table["condition"]) == {"delay", "noise", "omega", "lag", "strength"}
    assert got.table["moves"].all()


class Pushing:
    """A pilot that begins to push all lanes at its second step."""

    phase = np.zeros((1, 3))

    def reset(self) -> None:
        self.steps = 0

    def act(self, observed: np.ndarray) -> np.ndarray:
        self.steps += 1
        return np.full((3, 1), float(self.steps > 1))


def test_weak_and_lagging_actuators_do_in_an_environment_what_they_do_on_a_body():
    task, none = on_scales(height="height").experiment, np.zeros(3)
    changes = {"delay_s": none, "noise": none, "seed": none}
    changes |= {"strength": np.array([1.0, 0.5, 1.0]), "lag_s": np.array([0.0, 0.0, 0.04])}
    pilot = _PerturbedPilot(Pushing(), task, changes)
    arrives = np.array([pilot.act(np.zeros((3, 3)))[:, 0] for _ in range(3)])
    rate = task.wires.step_s / 0.04
    gone = 1.0 - math.exp(-rate)
    first = 1.0 - gone / rate  # the mean over a step of a first-order lag
    second = gone + (1.0 - gone) * first
    expected = [[0.0, 0.0, 0.0], [1.0, 0.5, first], [1.0, 0.5, second]]
    np.testing.assert_allclose(arrives, expected, rtol=1e-12)


def test_an_environment_that_says_neither_distance_nor_height_is_refused():
    refused("name the observation of its height in the wiring", on_scales)
