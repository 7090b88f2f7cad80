"""An experiment on an environment: which limbs are trained, where, and by what objective."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import msgspec
import numpy as np

from tegotae._support.documents import JsonObject, fitted, texts_in
from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_RAD_PER_S
from tegotae._support.part_code import code_of_file
from tegotae.envs.contact import with_contact
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.wires import Wires, controller_of_wiring, look_up
from tegotae.envs.wiring import Wiring, read_by, wiring_document, wiring_of
from tegotae.measures.objectives.evaluator import Evaluator
from tegotae.parts.bodies import Interface
from tegotae.parts.parameters import Part, positive, whole
from tegotae.parts.units import Units
from tegotae.systems.controller_file import ControllerSet, SavedController
from tegotae.systems.descriptions import describe, restore
from tegotae.systems.env_documents import EnvTask, WiringDocument
from tegotae.systems.experiment import Trainable, require_name
from tegotae.systems.recipe import Recipe
from tegotae.systems.registry import require_named
from tegotae.systems.system import System
from tegotae.systems.term_sets import BUDGET
from tegotae.training.environments.objectives import (
    EnvObjective,
    Hopping,
    Return,
    UserObjective,
)

_OF_EPISODES = ("duration_s", "episodes", "seed", "evaluation_episodes")
"""Fields that a file's task calls the same."""


@dataclass(frozen=True, kw_only=True)
class EnvExperiment(Part, Trainable):
    """An experiment on an environment; `tegotae.training.run.Run` takes it as any other.

    Args:
        name: what it is called, in files and tables.
        spec: the environment.
        wiring: the limbs, without weights; its controller is what is trained, at its ω.
        objective: the measure of an episode.
        duration_s: length of an episode [s], if the environment does not end it before.
        episodes: how many episodes each candidate has; on a MuJoCo model several take its
            setting `noise`.
        omegas: frequencies that the episodes have in turn [rad/s], so that one law is learned for
            all of them; the wiring's alone if there are none.
        seed: of the first episode's reset.
        evaluation_episodes: how many episodes the evaluation set has, a multiple of `episodes`.
            With some, every generation draws starts of its own, the same for all its candidates,
            and the centre of its distribution, by which the best is chosen, meets the evaluation
            set. Without, all episodes of all generations have the same starts.
        limit_s: longest time that one step of the environment may take in a worker [s].

    Raises:
        TegotaeError: for what cannot be made, or does not fit together.

    Example:
        >>> from tegotae.envs import load_wiring
        >>> from tegotae.systems.recipe import recipe
        >>> wiring = dataclasses.replace(
        ...     load_wiring("hopper").reading(recipe("ART").controller()), omega=8.0
        ... )
        >>> experiment = EnvExperiment(
        ...     name="art", spec=EnvSpec(env="hopper"), wiring=wiring, objective=Hopping()
        ... )
        >>> experiment.controller.n_weights
        96
    """

    name: str
    spec: EnvSpec
    wiring: Wiring
    objective: EnvObjective = field(default_factory=Return)
    duration_s: float = positive(24.0)
    episodes: int = whole(1)
    omegas: tuple[float, ...] = ()
    seed: int = whole(0, least=0)
    evaluation_episodes: int = whole(0, least=0)
    limit_s: float = positive(60.0)

    def __post_init__(self) -> None:
        require_name(self.name)
        super().__post_init__()
        if self.evaluation_episodes % self.episodes:
            raise TegotaeError(
                f"the evaluation set has {self.evaluation_episodes} episodes and a candidate "
                f"{self.episodes}; give as many, or a multiple of them"
            )
        if self.wiring.controller.oscillator is None:
            raise TegotaeError(
                f"{self.name} has no oscillator, which every limb of a wiring has; take a model "
                "that has one, such as ART"
            )
        if self.wiring.omega is None:
            raise TegotaeError(f"{self.name} has an oscillator; give it an omega, such as 8 rad/s")
        require_finite("omega", self.wiring.omega, above=0.0, most=MOST_RAD_PER_S)
        for frequency in self.omegas:
            require_finite("omega", frequency, above=0.0, most=MOST_RAD_PER_S)
        if self.omegas and self.episodes % len(self.omegas):
            raise TegotaeError(
                f"there are {self.episodes} episodes for {len(self.omegas)} frequencies; give as "
                "many, or a multiple of them"
            )
        episode_s = dict(self.spec.settings).get("duration_s", self.duration_s)
        if self.spec.is_model and episode_s != self.duration_s:
            raise TegotaeError(
                f"{self.spec.env} is made with duration_s={episode_s!r}, and the experiment's "
                f"duration_s is {self.duration_s:g}; say it of the experiment alone (--duration-s)"
            )

    @classmethod
    def from_recipe(
        cls,
        recipe: Recipe,
        spec: EnvSpec,
        wiring: Wiring,
        *,
        omega: float | Sequence[float] | None = None,
        **settings: Any,
    ) -> EnvExperiment:
        """Return the experiment that trains a recipe's controller on an environment.

        The frequency is the one given, else the wiring's, else the recipe's ω_t; of several, each
        has an episode, and the middle one is the controller's own. The objective is
        CoT⁻¹ + ΔΩ where the wiring says what height and work are, and otherwise the environment's
        return.

        Raises:
            TegotaeError: for a frequency, given or the wiring's, that is none.
        """
        controller = recipe.controller(settings.pop("budget", BUDGET))
        if wiring.omega is not None:
            require_finite("the wiring's omega", wiring.omega, above=0.0, most=MOST_RAD_PER_S)
        if isinstance(omega, Sequence):
            if len(omega) > 1:
                settings = {"omegas": tuple(omega), "episodes": len(omega), **settings}
            omega = sorted(omega)[len(omega) // 2] if omega else None
        if omega is None:
            omega = wiring.omega
        if omega is None and recipe.omega_t is not None:
            omega = recipe.omega_t / (wiring.units or Units()).time_s
        wiring = dataclasses.replace(wiring.reading(controller), omega=omega, weights=None)
        is_measured = wiring.height is not None and wiring.work is not None
        duration_s = settings.get("duration_s", 24.0)
        objective = Hopping(settle_s=0.5 * duration_s) if is_measured else Return()
        fields = {"name": recipe.name, "spec": spec, "wiring": wiring, "objective": objective}
        return cls(**{**fields, **settings})

    @cached_property
    def system(self) -> System:  # type: ignore[override]
        """The closed loop, as far as it is here: a unit a limb, their interface and ω.

        The interface has None for entries that the wiring lacks.
        """
        controller, wiring = controller_of_wiring(self.wiring), self.wiring
        senses = tuple(read_by(controller))
        scales = {name: float(scale) for name, scale in wiring.scales.items()}
        rest_m = wiring.rest_length_m
        interface = Interface(
            senses=senses,
            scales=tuple(scales.get(name) for name in senses),
            limbs=controller.limbs,
            commands=controller.actuation.COMMANDS,
            max_force_n=float(wiring.max_force),
            rest_length_m=None if rest_m is None else float(rest_m),
            feedback_scale=scales.get("feedback"),
        )
        return System(controller=controller, body=interface, omega=wiring.omega)

    @property
    def task(self) -> EnvTask:
        """The rest: the environment, the wiring, the objective and the episodes."""
        return EnvTask(
            env=self.spec.env,
            settings=dict(self.spec.settings),
            wiring=fitted(wiring_document(self.wiring), WiringDocument),
            objective=describe(self.objective),
            omegas=list(self.omegas),
            sha256=self._sha256,
            **{name: getattr(self, name) for name in _OF_EPISODES},
        )

    @classmethod
    def from_controller(cls, saved: SavedController | ControllerSet) -> EnvExperiment:
        """Return the experiment in which a saved controller, or the runs of a set, were trained.

        Raises:
            TegotaeError: for a controller that was not trained on an environment, or whose task
                refers to code that the user did not name (`require_named`).

        Example:
            >>> from tegotae.systems.controller_file import load
            >>> EnvExperiment.from_controller(load("leg.json")).spec  # doctest: +SKIP
            EnvSpec(env='leg', settings=())
        """
        task = saved.task
        if task is None or saved.name is None:
            raise TegotaeError(
                f"{saved.name or 'the controller'} was not trained on an environment; give one "
                "that was (tegotae train --env)"
            )
        wiring = wiring_of(task.wiring).reading(saved.system.controller)
        for text in texts_in(task.objective):
            require_named(text, f"the objective of {saved.name}")
        return cls(
            name=saved.name.partition(" (")[0],  # of a set what differs in it follows
            spec=EnvSpec.of_document(task.env, task.settings, f"the task of {saved.name}"),
            wiring=dataclasses.replace(wiring, omega=saved.system.omega),
            objective=restore(task.objective, Return | Hopping | UserObjective, "objective"),
            omegas=tuple(task.omegas),
            **{name: getattr(task, name) for name in _OF_EPISODES},
        )

    @cached_property
    def wires(self) -> Wires:
        """The wiring looked up in the environment.

        Raises:
            TegotaeError: if something is missing, all of it in one line.
        """
        env = with_contact(self.spec.make(), self.wiring.contact_bodies)
        try:
            wires, problems = look_up(env, self.wiring)
            if wires is None:
                raise TegotaeError(f"{self.spec.env}: " + "; ".join(problems))
            return wires
        finally:
            env.close()

    def check(self) -> None:
        """Check that it can be trained, before long work starts.

        Raises:
            TegotaeError: if not.
        """
        if self.controller.n_weights == 0:
            raise TegotaeError(f"{self.name} has no weights to train")
        _ = self.wires
        repeats = max(self.episodes, self.evaluation_episodes) // max(1, len(self.omegas))
        if repeats > 1 and self.spec.is_model and self.spec.model_settings.noise == 0.0:
            raise TegotaeError(
                f"the {repeats} episodes on {self.spec.env} would be alike; take one, or "
                "let their starts differ with the setting noise, such as noise=0.01"
            )
        self.objective.check(self.wiring, self.duration_s)

    def wiring_in(self, episode: int) -> Wiring:
        """Return the wiring of an episode, at the episode's frequency."""
        if not self.omegas:
            return self.wiring
        return dataclasses.replace(self.wiring, omega=self.omegas[episode % len(self.omegas)])

    @cached_property
    def evaluation_starts(self) -> np.ndarray:
        """Seeds of the resets of the evaluation set, [times, episodes]."""
        count = max(self.episodes, self.evaluation_episodes)
        return (self.seed + np.arange(count)).reshape(-1, self.episodes)

    def starts(self, *key: int) -> np.ndarray:
        """Return the seeds of the resets of a candidate's episodes, [1, episodes].

        Args:
            key: of the draw, such as the run's seed and the generation; of no effect where all
                generations have the same starts.
        """
        if not self.evaluation_episodes:
            return self.evaluation_starts
        drawn = np.random.SeedSequence([self.seed, *key]).generate_state(self.episodes)
        return drawn[None].astype(np.int64)

    def evaluator(self, workers: int | None = None) -> Evaluator:
        """Return the evaluator of candidate weights' fitness (`EnvEvaluator`).

        Args:
            workers: worker processes; one a core by default, and none for a MuJoCo model.
        """
        from tegotae.training.environments.evaluator import EnvEvaluator

        return EnvEvaluator(self, workers)

    @property
    def gains(self) -> np.ndarray:
        """Values of σ that a search tries, [rad/(s N)]: of the order of the body's own rates.

        The feedback σ F_k is from a hundredth to ten times √(g / l) under the usual load.
        """
        rate = float(self.wiring.scales.get("feedback", 1.0))
        load = float(self.wiring.scales.get("spring_force", 1.0))
        return np.geomspace(0.01, 10.0, 32) * rate / load

    @property
    def document(self) -> JsonObject:
        """The experiment as plain JSON values."""
        return {
            "name": self.name,
            "controller": describe(self.controller),
            "omega": self.omega,
            "body": describe(self.system.body),
            **msgspec.to_builtins(self.task),
        }

    @cached_property
    def _sha256(self) -> dict[str, str]:
        """Return the hashes of the files that the experiment names, by role: a changed file is
        another training."""
        files = {"environment": self.spec.file, "fitness": self.objective.file}
        return {role: code_of_file(file) for role, file in files.items() if file and file.is_file()}
