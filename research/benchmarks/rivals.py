"""Programs of the race: each trains ART, 96 weights, from a seed, and yields what it has learned.

A program is a function from seeds to an iterator of weights, [seeds, n_weights], after each step
of learning: a generation, or ten episodes of an agent. Those that use libraries which this
package does not need import them when they start.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import Any, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np

from research.benchmarks.textbook import textbook_controller
from tegotae.measures.objectives.evaluator import Evaluator, Generation
from tegotae.measures.objectives.fitness import HopOutcome
from tegotae.measures.objectives.objective import EpisodeOutcome, EpisodeSummary, Scores, scores
from tegotae.parts.bodies import Hopper
from tegotae.parts.controller import Controller
from tegotae.simulation.episode import EpisodeProgram, LaneInputs, LoopState, Shared
from tegotae.simulation.integrators import PredictorCorrector, sample
from tegotae.simulation.loop import ClosedLoop
from tegotae.simulation.recorder import Trajectory
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import recipe
from tegotae.training.agents import agent_controller
from tegotae.training.algorithms import PGPE
from tegotae.training.evolution import Evolution
from tegotae.training.learner import initial_weights
from tegotae.training.settings import tuned

LAW = "ART-rF-tphif-w4"
"""Law of the race: four learned terms at a commanded frequency of 4 rad/s."""
AGENTS_LAW = "AR-rF-sector-w4"
"""Law of the agent: without a learned actuation, whose weights no gradient reaches."""
SHARE = 0.01
"""Part of an episode that MJX simulates in a generation."""

Learning: TypeAlias = Iterator[np.ndarray]


def experiment() -> Experiment:
    """Return the training of the race: an episode of 24 s in control periods of 2 ms."""
    return recipe(LAW).experiment()


def learn_natively(seeds: Sequence[int]) -> Learning:
    """Train with this package: evosax's PGPE on native code, all seeds side by side."""
    return _centres(experiment(), seeds)


def learn_in_textbook_style(seeds: Sequence[int]) -> Learning:
    """Train with evosax's PGPE on `jax.vmap` of a `lax.scan`, all seeds side by side."""
    return _centres(_TextbookExperiment(**_fields(experiment())), seeds)


def learn_with_evotorch(seeds: Sequence[int]) -> Learning:
    """Train one seed with EvoTorch's PGPE at the settings of ours, on the textbook's rollouts."""
    evotorch, algorithms = map(import_module, ("evotorch", "evotorch.algorithms"))
    torch = import_module("torch")
    (seed,), trained, settings = seeds, experiment(), PGPE()
    torch.manual_seed(seed)

    def fitness(candidates: Any) -> Any:
        return torch.as_tensor(np.array(textbook_scores(trained, candidates.numpy())["fitness"]))

    first = initial_weights(trained.controller, seed)
    problem = evotorch.Problem(
        "max", fitness, solution_length=len(first), initial_bounds=(0.0, 0.0), vectorized=True
    )
    search = algorithms.PGPE(
        problem,
        popsize=settings.population,
        center_init=torch.tensor(first),
        center_learning_rate=settings.learning_rate,
        stdev_init=settings.std,
        stdev_learning_rate=settings.std_lr,
        stdev_max_change=settings.std_max_change,
        optimizer="clipup",
        optimizer_config={"max_speed": settings.max_speed, "momentum": settings.momentum},
        ranking_method="centered",
    )
    while True:
        search.step()
        yield search.status["center"].numpy()[None]


def learn_with_qdax(seeds: Sequence[int]) -> Learning:
    """Search one seed with QDax's MAP-Elites over ΔΩ and the climb, on the textbook's rollouts.

    It yields the best member of the repertoire.
    """
    elites = import_module("qdax.core.map_elites").MAPElites
    mixing = import_module("qdax.core.emitters.standard_emitters").MixingEmitter
    operators = import_module("qdax.core.emitters.mutation_operators")
    grid = import_module("qdax.core.containers.mapelites_repertoire")
    metrics = import_module("qdax.utils.metrics").default_qd_metrics
    (seed,), trained, batch = seeds, experiment(), PGPE().population

    def scored(genotypes: jax.Array, _: Any) -> tuple[jax.Array, jax.Array, dict[str, Any]]:
        values = textbook_scores(trained, genotypes)
        descriptors = jnp.stack([values["delta_omega"], values["climb_m"]], axis=-1)
        return values["fitness"], descriptors, {}

    vary = partial(operators.isoline_variation, iso_sigma=0.1, line_sigma=0.3)
    emitter = mixing(lambda x, y: (x, y), vary, 1.0, batch)
    search = elites(scored, emitter, partial(metrics, qd_offset=20.0))
    centroids = grid.compute_euclidean_centroids((16, 16), minval=(-4.0, 0.0), maxval=(0.0, 12.0))
    key, start, draw = jax.random.split(jax.random.key(seed), 3)
    first = initial_weights(trained.controller, seed)
    genotypes = first + PGPE().std * jax.random.normal(draw, (batch, len(first)))
    repertoire, state, _ = search.init(genotypes, centroids, start)
    update = jax.jit(search.update)
    while True:
        best = jnp.argmax(repertoire.fitnesses.ravel())
        yield np.asarray(repertoire.genotypes)[best][None]
        key, drawn = jax.random.split(key)
        repertoire, state, _ = update(repertoire, state, drawn)


def learn_with_ppo(seeds: Sequence[int]) -> Learning:
    """Train one seed with Stable-Baselines3's PPO, tuned, on `tegotae/TegotaeHopper-v0`.

    Its action is the feedback of AR, every 10 ms, and its reward that of a hop.
    """
    from tegotae.training.agents.learning import agent_task, learn

    task = agent_task(recipe(AGENTS_LAW).experiment(), tuned("ppo"))
    silent = dataclasses.replace(task, judge=lambda weights: (np.nan, np.nan))
    points = learn(silent, seed=seeds[0], episodes=10**6, evaluate_every=10)
    next(points)  # the policy before training
    for _, weights in points:
        yield weights[None]


def simulate_with_mjx(seeds: Sequence[int]) -> Learning:
    """Advance a generation of one seed on MuJoCo's hopper by MJX, for a part of an episode.

    Nothing is learned: it is the cost of a generation that is measured. MJX has no adhesion, so
    that the foot is free.
    """
    mjx, mujoco = map(import_module, ("mujoco.mjx", "mujoco"))
    from tegotae.envs.mujoco.settings import model_files

    trained, controller = experiment(), textbook_controller()
    spec = mujoco.MjSpec.from_string(model_files()["hopper"])
    spec.delete(spec.actuator("grip"))
    compiled = spec.compile()
    model, hopper = mjx.put_model(compiled), Hopper()
    tick_s = trained.timing.tick_s
    substeps = round(tick_s / compiled.opt.timestep)
    periods = round(SHARE * trained.duration_s / tick_s)
    numbers = {
        "omega": jnp.float32(trained.omega or 0.0),
        "scales": {"spring_force": hopper.weight_n, "feedback": 3.132},
        "max_force": hopper.max_force_n,
        "step_s": jnp.float32(tick_s),
    }

    def climb(weights: jax.Array) -> jax.Array:
        def period(carry: Any, _: None) -> tuple[Any, jax.Array]:
            data, oscillator = carry
            spring = jnp.maximum(-hopper.stiffness_n_per_m * data.qpos[1], 0.0)
            sensed, added = {"spring_force": spring}, jnp.float32(0.0)
            decision = sample(controller, weights, oscillator, sensed, added, numbers)
            oscillator, command = decision[:2]
            data = data.replace(ctrl=jnp.reshape(command * hopper.max_force_n, (1,)))
            data = jax.lax.fori_loop(0, substeps, lambda _, d: mjx.step(model, d), data)
            return (data, oscillator), data.qpos[0]

        assert controller.oscillator is not None
        data = mjx.make_data(model)
        data = data.replace(qpos=data.qpos.at[0].add(0.2))
        begun = data, controller.oscillator.start(jnp.float32(0.0))
        return jax.lax.scan(period, begun, None, length=periods)[1].max()

    rollouts = jax.jit(jax.vmap(climb))
    rng, first = np.random.default_rng(seeds[0]), initial_weights(trained.controller, seeds[0])
    while True:
        candidates = first + 0.1 * rng.normal(size=(PGPE().population + 1, len(first)))
        rollouts(jnp.asarray(candidates, "float32")).block_until_ready()
        yield first[None]


@dataclass(frozen=True)
class Rival:
    """Program of the race.

    Args:
        title: name in the table.
        learn: the program.
        package: module that it needs beside this package; empty without one.
        seeds: number of seeds.
        together: seeds of one process.
        steps: largest number of steps of learning.
        law: name of the law that it trains.
        share: part of an episode that it simulates.
    """

    title: str
    learn: Callable[[Sequence[int]], Learning]
    package: str = ""
    seeds: int = 10
    together: int = 1
    steps: int = 60
    law: str = LAW
    share: float = 1.0

    @property
    def controller(self) -> Controller:
        """Controller that its weights are of."""
        trained = recipe(self.law).experiment()
        return trained.controller if self.law == LAW else agent_controller(trained, tuned("ppo"))


RIVALS = {
    "tegotae": Rival("tegotae", learn_natively, seeds=10),
    "textbook": Rival("textbook JAX", learn_in_textbook_style, seeds=10),
    "evotorch": Rival(
        "EvoTorch's PGPE, textbook rollouts", learn_with_evotorch, "evotorch", seeds=5
    ),
    "qdax": Rival("QDax's MAP-Elites, textbook rollouts", learn_with_qdax, "qdax", seeds=5),
    "ppo": Rival(
        "Stable-Baselines3's PPO",
        learn_with_ppo,
        "stable_baselines3",
        seeds=5,
        steps=19,
        law=AGENTS_LAW,
    ),
    "tegotae-10": Rival("tegotae, ten seeds at once", learn_natively, together=10),
    "textbook-10": Rival("textbook JAX, ten seeds at once", learn_in_textbook_style, together=10),
    "mjx": Rival("MJX", simulate_with_mjx, "mujoco.mjx", seeds=2, steps=4, share=SHARE),
}
"""Programs of the race by name, in the order of the table."""


def _centres(trained: Experiment, seeds: Sequence[int]) -> Learning:
    """Yield the means of the search distributions after each generation, with ours of evosax."""
    for progress, _ in Evolution().evolve(trained, seeds):
        yield np.asarray(progress.search.mean)


def _fields(value: Any) -> dict[str, Any]:
    return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}


class _TextbookExperiment(Experiment):
    """The training of the race, on rollouts in textbook style."""

    def evaluator(self, workers: int | None = None) -> Any:
        return _TextbookEvaluator(self)


@dataclass(frozen=True)
class _TextbookEvaluator(Evaluator):
    """Scores by rollouts in textbook style."""

    experiment: Experiment

    @property
    def repeats(self) -> int:
        return 1

    def scored(self, weights: np.ndarray, per_seed: int, generation: Generation) -> Scores:
        values = textbook_scores(self.experiment, weights.reshape(-1, weights.shape[-1]))
        return Scores(*(np.array(values[x]).reshape(weights.shape[:2]) for x in Scores._fields))


def textbook_scores(trained: Experiment, weights: Any) -> dict[str, jax.Array]:
    """Return the scores of episodes by `jax.vmap` over a `lax.scan`, [candidates] each.

    The scheme, the body and the fitness are those of the package; the networks are matrix products
    and the sine is JAX's own.

    Args:
        trained: law, body, release and fitness.
        weights: [candidates, n_weights].
    """
    return _textbook_scores(trained, jnp.asarray(weights, "float32"))


@partial(jax.jit, static_argnums=0)
def _textbook_scores(trained: Experiment, weights: jax.Array) -> dict[str, jax.Array]:
    timing, measure = trained.timing, trained.measure
    loop = ClosedLoop(textbook_controller(), PredictorCorrector())
    program = EpisodeProgram(loop, measure.needs)
    scenario = jax.tree.map(jnp.float32, trained.scenario)
    shared = Shared(trained.body, jnp.float32(timing.tick_s))

    def trajectory(row: jax.Array) -> Trajectory:
        lane = LaneInputs(tuple(row), scenario)

        def tick(state: LoopState, index: jax.Array) -> tuple[LoopState, None]:
            return program.tick(lane, shared, state, index), None

        def frame(state: LoopState, number: jax.Array) -> tuple[LoopState, Trajectory]:
            first = number * timing.ticks_per_frame
            state, _ = jax.lax.scan(tick, state, first + jnp.arange(timing.ticks_per_frame))
            return program.frame(lane, shared, state, first + timing.ticks_per_frame - 1)

        start = program.start(lane, shared)
        return jax.lax.scan(frame, start, jnp.arange(timing.n_frames))[1]

    recorded = jax.tree.map(jnp.transpose, jax.vmap(trajectory)(weights))
    lanes = jax.tree.map(lambda x: jnp.broadcast_to(x, weights.shape[:1]), scenario)
    episode = EpisodeSummary(measure)(recorded, lanes, trained.body, timing)
    assert isinstance(episode, EpisodeOutcome)
    outcome: HopOutcome = episode.outcome
    return {**scores(measure, episode, measure.data), "climb_m": outcome.climb_m}
