"""An agent's training on disk: controllers and curves, one seed after the other."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tegotae._support.devices import set_up
from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.progress import reporting
from tegotae._support.tables import numbers, parse_csv, write_csv
from tegotae._support.workplace import TRAINING, alone
from tegotae.parts.bodies import require_one_limb
from tegotae.parts.controller import Controller
from tegotae.simulation.integrators import PredictorCorrector
from tegotae.systems.descriptions import check_kept
from tegotae.systems.experiment import Experiment
from tegotae.systems.release import Release
from tegotae.training.agents.policy import agent_controller
from tegotae.training.agents.settings import AgentSettings, SACSettings
from tegotae.training.algorithms.document import algorithm_document
from tegotae.training.folder import claim, save_controller, versions_of

if TYPE_CHECKING:
    from tegotae.training.agents.learner import AgentTraining, Point

COLUMNS = ("episode", "simulated_s", "cot_inverse", "fitness", "seed")
"""Columns of `curves.csv`; see `tegotae.training.agents.learner.Point`."""

_SECONDS_BETWEEN_WRITES = 5.0


@dataclass(frozen=True, kw_only=True)
class AgentRun:
    """A training of agents: what, from which seeds, how, and how long.

    Args:
        experiment: what is trained. Its control period is that of the evaluations; an agent is not
            paid for ΔΩ, and so it is not judged by it.
        seeds: one training from random weights each.
        episodes: how long each learns, in simulated time of so many whole episodes.
        settings: how is learned.
        evaluate_every: episodes between two points of the learning curve.

    Raises:
        TegotaeError: for a count below one, a controller without a meaning for agents, or a body
            of several limbs.
    """

    experiment: Experiment
    seeds: tuple[int, ...] = (0, 1, 2)
    episodes: int = 1000
    settings: AgentSettings = field(default_factory=SACSettings)
    evaluate_every: int = 10

    def __post_init__(self) -> None:
        require_count("seeds", len(self.seeds))
        require_count("episodes", self.episodes)
        require_count("evaluate_every", self.evaluate_every)
        require_one_limb(self.experiment.body, "learning by agents")
        release = self.experiment.system.release
        if release != Release(height_m=release.height_m):
            raise TegotaeError(
                "agents learn from releases at rest and phase 0; give height_m alone"
            )
        if self.experiment.conditions:
            raise TegotaeError(
                "agents learn in the same episode again and again; leave the experiment's "
                "conditions, which a population can have (pgpe)"
            )
        if self.experiment.system.integrator != PredictorCorrector():
            raise TegotaeError(
                "agents learn in continuous time; leave the experiment's integrator, which a "
                "population can have (pgpe)"
            )
        _ = self.controller

    @property
    def controller(self) -> Controller:
        """The policy."""
        return agent_controller(self.experiment, self.settings)

    @property
    def training(self) -> AgentTraining:
        """What is learned and how.

        Raises:
            MissingExtraError: without Stable-Baselines3.
        """
        from tegotae.training.agents.learner import AgentTraining

        return AgentTraining.of(self.experiment, self.settings)

    @property
    def configuration(self) -> dict[str, Any]:
        """What decides a seed's result, but for the number of episodes, as JSON values."""
        objective = self.experiment.objective.without_frequency()
        return {
            "experiment": self.experiment.replaced(objective=objective).document,
            "algorithm": algorithm_document(self.settings),
            "evaluate_every": self.evaluate_every,
        }


def train_agents(
    run: AgentRun,
    out: Path,
    *,
    anew: bool = False,
    on_point: Callable[[int, Point], None] | None = None,
) -> list[Path]:
    """Train, or go on, in the folder `out`; return the controller files, one per seed.

    Written are `MODEL-seedN.json` (the policy of the best point of the curve), `curves.csv` and
    `run.json` (configuration and versions). Interrupted (Ctrl-C), it keeps what has been learned
    and raises `KeyboardInterrupt` again. Called again on the same folder, it leaves the seeds that
    are done and begins the one that was interrupted anew, to the same numbers.

    Args:
        run: what, from which seeds, how, and how long.
        out: the folder.
        anew: whether a training that is there before is set aside, in a folder beside it.
        on_point: called with the seed and each new point.

    Raises:
        TegotaeError: if the folder cannot be written, is in use or holds another training, or a
            seed diverges.
        MissingExtraError: without Stable-Baselines3.
    """
    set_up()
    run.experiment.check()
    check_kept(run.settings)
    training, configuration = run.training, run.configuration
    with alone(out, TRAINING, anew=anew):
        claim(out, configuration, _software())
        return _train(run, training, out, on_point)


def _train(
    run: AgentRun,
    training: AgentTraining,
    out: Path,
    on_point: Callable[[int, Point], None] | None,
) -> list[Path]:
    """The same, alone in the folder."""
    from tegotae.training.agents.learner import learn

    curves = _read_curves(out)
    with reporting(run.experiment.name, len(run.seeds) * run.episodes) as reporter:
        for i, seed in enumerate(run.seeds):
            if _is_done(run, seed, curves, out):
                continue
            points: list[Point] = []
            saved_at = time.monotonic()
            steps = learn(
                training, seed=seed, episodes=run.episodes, evaluate_every=run.evaluate_every
            )
            try:
                for point in steps:
                    points.append(point)
                    reporter.update(
                        i * run.episodes + min(round(point.episode), run.episodes),
                        f"seed {seed}  CoT⁻¹ {point.cot_inverse:.3f} m/J",
                    )
                    if on_point is not None:
                        on_point(seed, point)
                    if time.monotonic() - saved_at > _SECONDS_BETWEEN_WRITES:
                        _write(run, seed, points, curves, out)
                        saved_at = time.monotonic()
            finally:
                if points:
                    _write(run, seed, points, curves, out)
    return [_file(run, seed, out) for seed in run.seeds]


def _software() -> dict[str, str]:
    return versions_of("stable-baselines3", "torch", "gymnasium")


def _file(run: AgentRun, seed: int, out: Path) -> Path:
    return out / f"{run.experiment.name}-seed{seed}.json"


_Curves = dict[int, list[list[str]]]
"""The rows of `curves.csv`, by seed."""


def _read_curves(out: Path) -> _Curves:
    path = out / "curves.csv"
    curves: _Curves = {}
    if not path.exists():
        return curves
    try:
        columns = parse_csv(path.read_text(encoding="utf-8"))
        if tuple(columns) != COLUMNS:
            raise ValueError("other columns")
        for row in zip(*columns.values(), strict=True):
            *told, seed = row
            numbers(told)
            curves.setdefault(int(seed), []).append([str(cell) for cell in row])
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except ValueError:
        raise TegotaeError(
            f"{path} is damaged; remove it to train anew, or choose another folder with --out"
        ) from None
    return curves


def _is_done(run: AgentRun, seed: int, curves: _Curves, out: Path) -> bool:
    learned = float(curves[seed][-1][0]) if seed in curves else 0.0
    return learned >= run.episodes and _file(run, seed, out).exists()


def _write(run: AgentRun, seed: int, points: list[Point], curves: _Curves, out: Path) -> None:
    """Write the best policy of this seed so far, and all curves."""
    best = max(points, key=lambda point: point.fitness)
    save_controller(
        out,
        experiment=run.experiment,
        controller=run.controller,
        weights=best.weights,
        configuration=run.configuration,
        outcome={
            "seed": seed,
            "episodes": points[-1].episode,
            "simulated_s": points[-1].simulated_s,
            "best_fitness": best.fitness,
            "best_episode": best.episode,
        },
        versions=_software(),
    )
    curves[seed] = [[*(f"{x:.6g}" for x in point[:4]), str(seed)] for point in points]
    rows = [row for _, of_seed in sorted(curves.items()) for row in of_seed]
    write_csv(out / "curves.csv", dict(zip(COLUMNS, zip(*rows, strict=True), strict=True)))
