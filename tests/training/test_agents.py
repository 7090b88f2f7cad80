"""SAC and PPO learn PGPE's own policy, into the same files, or say why they cannot."""

import csv
import dataclasses
import json
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("stable_baselines3")

from refusals import refused  # noqa: E402
from tegotae import (  # noqa: E402
    Hopper,
    Rollout,
    Scenario,
    TegotaeError,
    Timing,
)
from tegotae.cli import main  # noqa: E402
from tegotae.envs import make_sb3  # noqa: E402
from tegotae.measures.objectives.fitness import Fitness  # noqa: E402
from tegotae.parts.terms import Signals  # noqa: E402
from tegotae.simulation.integrators import Hold  # noqa: E402
from tegotae.systems import controller_file  # noqa: E402
from tegotae.systems.recipe import recipe  # noqa: E402
from tegotae.training.agents import (  # noqa: E402
    PPOSettings,
    SACSettings,
    agent_controller,
)
from tegotae.training.agents.learner import AgentLearner  # noqa: E402
from tegotae.training.agents.learning import agent_task, hopper_settings, learn, make_agent  # noqa: E402
from tegotae.training.algorithms import PGPE  # noqa: E402
from tegotae.training.evolution import Evolution  # noqa: E402
from tegotae.training.learner import initial_weights  # noqa: E402
from tegotae.training.run import (  # noqa: E402
    COLUMNS,
    Run,
    train,
)
from tegotae.training.settings import learner  # noqa: E402

TIMING = Timing(duration_s=6.0, tick_s=0.002)
SETTLE_S = 2.0
LIMIT = 12.0
PPO = PPOSettings(n_steps=60, batch_size=200, n_epochs=5, learning_rate=3e-3)
SAC = SACSettings(learning_starts=1200, gradient_steps=1, batch_size=128, learning_rate=1e-3)
BOTH = pytest.mark.parametrize("settings", [SAC, PPO], ids=["sac", "ppo"])


@pytest.fixture(autouse=True, scope="module")
def _one_thread():
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


def experiment(model="AR-rF-sector-w8"):
    return recipe(model).experiment(timing=TIMING, objective=Fitness(settle_s=SETTLE_S))


def training(settings, model="AR-rF-sector-w8", **changes):
    return agent_task(experiment(model), dataclasses.replace(settings, **changes))


def environment(settings, model="AR-rF-sector-w8", **changes):
    return hopper_settings(experiment(model), dataclasses.replace(settings, **changes))


def played(task, weights):
    """Return the engine's trajectory of an undisturbed episode."""
    fitness = Fitness(settle_s=SETTLE_S, follow_omega=False)
    rollout = Rollout(controller=task.controller, timing=TIMING, summary=fitness)
    return rollout.run(weights, Scenario(omega=8.0))


def run(settings=PPO, **changes):
    learner = AgentLearner(settings=settings, episodes=4, evaluate_every=2)
    return Run(**{"experiment": experiment(), "seeds": (1,), **changes}, learner=learner)


def observations(learner, n=64):
    """Random observations, and the same as signals to a controller."""
    random = np.random.default_rng(0)
    names = learner.observed.names
    phase, force = random.uniform(0, 2 * np.pi, n), random.exponential(2.0, n)
    values = {"sin_phase": np.sin(phase), "cos_phase": np.cos(phase), "spring_force": force}
    values |= {"velocity": random.normal(size=n), "height": random.uniform(0.5, 1.5, n)}
    columns = np.stack([values[name] for name in names], axis=1).astype(np.float32)
    body = Hopper()
    scales = body.sense(body.release(jnp.ones(()), jnp.zeros(())), jnp.zeros(())).scales
    si = {name: jnp.asarray(columns[:, i]) * scales.get(name, 1.0) for i, name in enumerate(names)}
    return columns, Signals(si, scales)


def says(controller, weights, signals):
    """The controller's feedback as a share of its limit, [n]."""
    lanes = [jnp.full_like(signals["sin_phase"], w) for w in np.asarray(weights)]
    return controller.feedback(lanes, signals) / controller.tegotae.limit_rad_per_s


class TestPolicy:
    @BOTH
    @pytest.mark.parametrize(
        "model", ["AR-rF-sector-w8", "AR-rFv-reflex-w4", "A-both-w8", "R-rF-reflex-w8"]
    )
    def test_acts_as_the_controller_does(self, settings, model):
        learner = training(settings, model, max_feedback_rad_per_s=LIMIT)
        # Wide weights, so that the limit is felt.
        weights = 3.0 * initial_weights(learner.controller, 5)
        agent, _ = make_agent(learner, seed=0, weights=weights)
        observed, signals = observations(learner)
        action, _ = agent.predict(observed, deterministic=True)
        expected = says(learner.controller, weights, signals)
        assert np.ptp(expected) > 0.5
        np.testing.assert_allclose(action[:, 0], expected, atol=2e-5)

    @BOTH
    def test_has_the_controllers_gradient(self, settings):
        learner = training(settings)
        weights = initial_weights(learner.controller, 3)
        _, feedback = make_agent(learner, seed=0, weights=weights)
        observed, signals = observations(learner)
        torch.tanh(feedback(torch.tensor(observed))).sum().backward()
        ours = np.concatenate([p.grad.numpy() for p in feedback.parameters()])

        def total(w):
            lanes = [jnp.broadcast_to(x, signals["sin_phase"].shape) for x in jnp.unstack(w)]
            return learner.controller.feedback(lanes, signals).sum() / 40.0

        np.testing.assert_allclose(ours, jax.grad(total)(jnp.asarray(weights)), atol=1e-4)

    @BOTH
    def test_hands_back_the_weights_that_it_was_given(self, settings):
        learner = training(settings)
        weights = np.arange(learner.controller.n_weights, dtype=np.float32)
        _, feedback = make_agent(learner, seed=0, weights=weights)
        np.testing.assert_array_equal(feedback.flat(), weights)

    def test_starts_where_pgpe_starts(self):
        model = recipe("AR-rF-sector-w8")
        evolved = Evolution(algorithm=PGPE()).start(model.experiment(), [7]).best_weights[0]
        ours = initial_weights(agent_controller(model.experiment(), SAC), 7)
        np.testing.assert_allclose(ours, evolved, rtol=1e-6)

    @BOTH
    def test_explores_with_the_same_deviation_everywhere(self, settings):
        learner = training(settings, noise=0.05)
        agent, _ = make_agent(learner, seed=0, weights=np.zeros(learner.controller.n_weights))
        observed = np.repeat(observations(learner, n=4)[0], 2000, axis=0)
        actions, _ = agent.predict(observed)
        for place in actions.reshape(4, 2000):
            assert abs(place.mean()) < 0.005
            assert place.std() == pytest.approx(0.05, rel=0.1)

    @BOTH
    def test_does_not_see_what_is_shown_to_its_critics_alone(self, settings):
        plain, informed = training(settings), training(settings, critic_senses=("height",))
        assert informed.observed.names == (*plain.observed.names, "height")
        weights = initial_weights(plain.controller, 0)
        agent, _ = make_agent(informed, seed=0, weights=weights)
        observed, _ = observations(informed)
        action, _ = agent.predict(observed, deterministic=True)
        observed[:, -1] += 1.0
        changed, _ = agent.predict(observed, deterministic=True)
        np.testing.assert_array_equal(action, changed)


class TestEnvironment:
    def test_is_the_models(self):
        model, changes = "AR-rFv-reflex-w8", {"tick_s": 0.002, "decimation": 5}
        hoppers = environment(SAC, model, least_work_j=0.01, **changes)
        assert hoppers.observed == ("sin_phase", "cos_phase", "spring_force", "velocity")
        assert hoppers.actuation == training(SAC, model).controller.actuation
        assert (hoppers.step_s, hoppers.n_steps) == (pytest.approx(0.01), 600)
        assert hoppers.max_feedback_rad_per_s == 40.0
        assert hoppers.reward.least_work_j == 0.01

    def test_moves_as_the_saved_controller_does_in_the_engine(self, folder):
        # At one action a tick the environment is the engine with a sampled controller.
        saved = controller_file.load(folder / "AR-rF-sector-w8-seed1.json")
        ticks, tick_s = 500, 0.002
        timing = Timing(duration_s=ticks * tick_s, tick_s=tick_s, frame_s=tick_s)
        rollout = Rollout(controller=saved.controller, integrator=Hold(), timing=timing)
        expected = rollout.run(saved.weights, Scenario(omega=saved.omega))

        learner = training(PPO, tick_s=tick_s, decimation=1)
        hoppers = environment(PPO, tick_s=tick_s, decimation=1)
        agent, _ = make_agent(learner, seed=0, weights=saved.weights)
        env = make_sb3(
            "tegotae/TegotaeHopper-v0",
            **{f.name: getattr(hoppers, f.name) for f in dataclasses.fields(hoppers)},
        )
        observation, phases = env.reset(), []
        for _ in range(ticks):
            action, _ = agent.predict(observation, deterministic=True)
            observation, *_ = env.step(action)
            phases.append(observation[0, :2])
        trace = np.array(phases)
        np.testing.assert_allclose(trace[:, 0], np.sin(expected.phase_rad[:, 0]), atol=1e-3)
        np.testing.assert_allclose(trace[:, 1], np.cos(expected.phase_rad[:, 0]), atol=1e-3)


class TestLearning:
    @pytest.mark.parametrize(("settings", "seed"), [(SAC, 0), (PPO, 1)], ids=["sac", "ppo"])
    def test_improves_a_seeded_start(self, settings, seed):
        curve = [p.cot_inverse for p, _ in learn(
            training(settings), seed=seed, episodes=24, evaluate_every=4
        )]  # fmt: skip
        assert np.mean(curve[-3:]) > curve[0] + 0.1

    @BOTH
    def test_same_seed_same_weights_and_another_seed_others(self, settings):
        learner = training(settings)
        first, again, second = (
            list(learn(learner, seed=seed, episodes=4, evaluate_every=2)) for seed in (0, 0, 1)
        )
        assert [p.step for p, _ in first] == [0.0, 2.0, 4.0]
        assert [p.simulated_s for p, _ in first] == [0.0, 12.0, 24.0]
        for (_, ours), (_, theirs) in zip(first, again, strict=True):
            np.testing.assert_array_equal(ours, theirs)
        assert (first[-1][1] != second[-1][1]).any()

    def test_a_point_is_what_the_engine_says_of_its_weights(self):
        learner = training(PPO)
        point, weights = list(learn(learner, seed=2, episodes=2, evaluate_every=2))[-1]
        outcome = played(learner, weights)
        assert point.cot_inverse == outcome["cot_inverse"][0]
        assert point.fitness == outcome["fitness"][0]

    def test_rewards_can_be_normalised(self):
        points = list(learn(training(PPO, normalize_reward=True), seed=0, episodes=2))
        assert (points[0][1] != points[-1][1]).any()

    @BOTH
    def test_says_that_it_diverged(self, settings):
        wild = training(settings, learning_rate=1e30)
        with pytest.raises(TegotaeError, match=r"seed 0 diverged .* learning_rate"):
            list(learn(wild, seed=0, episodes=8, evaluate_every=2))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("agents")
    train(run(seeds=(0, 1)), out)
    return out


class TestFolder:
    def rows(self, folder):
        with (folder / "curves.csv").open() as stream:
            return list(csv.DictReader(stream))

    def test_holds_curves_controllers_and_configuration(self, folder):
        rows = self.rows(folder)
        assert tuple(rows[0]) == COLUMNS
        assert [(row["seed"], row["step"]) for row in rows] == [
            (seed, episode) for seed in "01" for episode in "024"
        ]
        assert rows[-1]["simulated_s"] == "24"
        configuration = json.loads((folder / "run.json").read_text())["configuration"]
        assert configuration["algorithm"]["name"] == "ppo"
        assert configuration["experiment"]["name"] == "AR-rF-sector-w8"
        versions = json.loads((folder / "run.json").read_text())["software"]
        assert {"torch", "stable-baselines3"} <= set(versions)

    def test_keeps_the_best_policy_of_each_seed(self, folder):
        for seed in (0, 1):
            saved = controller_file.load(folder / f"AR-rF-sector-w8-seed{seed}.json")
            points = [row for row in self.rows(folder) if row["seed"] == str(seed)]
            best = max(points, key=lambda row: float(row["fitness"]))
            assert saved.training["best_fitness"] == pytest.approx(float(best["fitness"]), rel=1e-5)
            assert saved.training["best_episode"] == float(best["step"])
            outcome = played(training(PPO), saved.weights)
            assert outcome["fitness"][0] == pytest.approx(saved.training["best_fitness"], rel=1e-5)

    def test_seeds_that_are_done_are_left_as_they_are(self, folder):
        content = (folder / "curves.csv").read_text()
        steps = []
        paths = train(run(seeds=(0, 1)), folder, on_step=steps.append)
        assert not steps
        assert [path.name for path in paths] == [f"AR-rF-sector-w8-seed{i}.json" for i in (0, 1)]
        assert (folder / "curves.csv").read_text() == content

    def test_an_interrupted_run_keeps_what_it_has_and_goes_on_to_the_same_numbers(
        self, folder, tmp_path
    ):
        def interrupt(step):
            if step.new[0][:2] == (1, 2):
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            train(run(seeds=(0, 1)), tmp_path, on_step=interrupt)
        finished = [(row["seed"], row["step"]) for row in self.rows(tmp_path)]
        assert finished == [("0", "0"), ("0", "2"), ("0", "4"), ("1", "0"), ("1", "2")]
        assert controller_file.load(tmp_path / "AR-rF-sector-w8-seed1.json")

        learned = []
        train(run(seeds=(0, 1)), tmp_path, on_step=lambda step: learned.append(step.new[0].seed))
        assert set(learned) == {1}
        assert self.rows(tmp_path) == self.rows(folder)
        for name in ("AR-rF-sector-w8-seed0.json", "AR-rF-sector-w8-seed1.json"):
            assert (tmp_path / name).read_text() == (folder / name).read_text()


class TestBadInput:
    @pytest.mark.parametrize("algorithm", ["sac", "ppo"])
    @pytest.mark.parametrize(
        ("model", "message"),
        [
            ("V-reflex-w8", "no network to learn"),
            ("T-Fv", "the Tegotae feedback, and it has none"),
            ("ART-rF-tphif-w8", "come after the agent's action"),
        ],
    )
    def test_models_without_a_meaning_are_refused(self, algorithm, model, message):
        agent = AgentLearner(settings=learner(algorithm)())
        with pytest.raises(
            TegotaeError, match=f"{algorithm} has no meaning for {model}: .*{message}"
        ):
            Run(experiment=recipe(model).experiment(), learner=agent)

    @pytest.mark.parametrize(
        ("kind", "settings", "message"),
        [
            (SACSettings, {"gamma": 1.5}, "gamma is 1.5; it must be at most 1"),
            (SACSettings, {"tau": 0.0}, "tau is 0; it must be greater than 0"),
            (SACSettings, {"n_envs": 0}, "n_envs is 0"),
            (SACSettings, {"noise": float("nan")}, "noise is nan; it must be finite"),
            (SACSettings, {"buffer_size": 10}, "buffer_size is 10; it must hold"),
            (PPOSettings, {"batch_size": 7}, "batch_size is 7; it must divide the 2400"),
            (PPOSettings, {"critic_layers": (8, -1)}, "critic_layers is -1"),
            (PPOSettings, {"max_feedback_rad_per_s": -1.0}, "max_feedback_rad_per_s is -1"),
        ],
    )
    def test_settings_out_of_range(self, kind, settings, message):
        refused(message, kind, **settings)

    def test_senses_that_do_not_exist(self):
        with pytest.raises(TegotaeError, match="no observation of this environment is called"):
            training(SAC, critic_senses=("colour",))

    def test_one_line_names_all_missing_extras(self, tmp_path):
        words = ["train", "AR", "--algorithm", "ppo", "--out", str(tmp_path)]
        program = (
            "import sys\n"
            "class Absent:\n"
            "    def find_spec(self, name, *_):\n"
            "        if name in ('gymnasium', 'mujoco', 'stable_baselines3', 'tensorboardX'):\n"
            "            raise ModuleNotFoundError('not installed', name=name)\n"
            "sys.meta_path.insert(0, Absent())\n"
            "from tegotae.cli import main\n"
            "for more in [], ['--env', 'leg'], ['--tensorboard']:\n"
            f"    assert main([*{words!r}, *more]) == 2\n"
        )
        process = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        assert process.returncode == 0, process.stderr
        alone, model, logs = process.stderr.splitlines()
        assert "stable_baselines3 is not installed; pip install torch --index-url" in alone
        assert "gymnasium, mujoco, stable_baselines3 are not installed" in model
        assert "then pip install 'tegotae[mujoco,sb3]', or in a clone" in model
        assert "then pip install 'tegotae[sb3,tensorboard]', or in a clone" in logs
        assert not list(tmp_path.iterdir())


def test_the_command_trains_and_prints(tmp_path, capsys):
    arguments = ["--algorithm", "ppo", "--episodes", "2", "--seeds", "1", "--out", str(tmp_path)]
    assert (
        main(["train", "AR-rF-sector-w8", *arguments, "--duration-s", "6", "--settle-s", "2"]) == 0
    )
    output = capsys.readouterr().out
    assert "best episode" in output
    assert (tmp_path / "AR-rF-sector-w8-seed0.json").exists()
