"""An experiment: what is trained, on what, by what measure, and how it is then evaluated."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Self, cast

import numpy as np

from tegotae._support.documents import Json, JsonObject
from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.measures.evaluation import Protocol
from tegotae.measures.objectives.evaluator import EngineEvaluator, Evaluator
from tegotae.measures.objectives.fitness import Fitness
from tegotae.measures.objectives.objective import Objective
from tegotae.parts.bodies import Hopper
from tegotae.parts.fields import replace
from tegotae.simulation.checks.passive import check_passive
from tegotae.simulation.draws import Randomization, check_conditions, check_releases
from tegotae.simulation.world import OMEGA, Condition, Scenario
from tegotae.systems.descriptions import UsersPartError, check_kept, describe, restore
from tegotae.systems.env_documents import EnvTask
from tegotae.systems.system import OnSystem, System

GAINS = np.linspace(0.1, 12.0, 240)
"""Values of σ that are tried on the paper's hopper [rad/(s N)]."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+@-]{0,99}")


class Trainable(OnSystem, ABC):
    """Experiment that can be trained, wherever its episodes take place: on the engine, or on an
    environment."""

    name: str
    """Name in files and tables."""
    duration_s: float
    """Duration of an episode [s]."""
    episodes: int
    """Number of episodes of each candidate."""

    @abstractmethod
    def evaluator(self, workers: int | None = None) -> Evaluator:
        """Return the evaluator of candidate weights' fitness.

        Args:
            workers: worker processes of an environment, one a core by default; the engine needs
                none.
        """

    @abstractmethod
    def check(self) -> None:
        """Raise `TegotaeError`, before long work starts, for an experiment that cannot be
        trained.
        """

    @property
    @abstractmethod
    def gains(self) -> np.ndarray:
        """Values of σ that a search tries [rad/(s N)]."""

    @property
    @abstractmethod
    def document(self) -> JsonObject:
        """Experiment as plain JSON values."""

    @property
    def task(self) -> EnvTask | None:
        """Environment of the training; None on the engine."""
        return None

    @property
    def is_searched(self) -> bool:
        """True if the only trained parameter is a constant gain σ, which a search finds."""
        return self.controller.has_a_gain_alone

    @property
    def searched_in(self) -> Sequence[Self]:
        """Experiments whose mean fitness a search for the gain maximises: this one alone."""
        return (self,)

    def without_frequency(self) -> Self:
        """Return the experiment as agents learn it, without a reward for a frequency."""
        return self

    @property
    def cot_unit(self) -> str:
        """Unit of CoT⁻¹."""
        return "m/J"


@dataclass(frozen=True, kw_only=True)
class Experiment(Trainable):
    """A system, the objective and conditions of its training, and the evaluation of the result.

    Trainings of any algorithm and the study are made of experiments; the 218 models of the
    paper make theirs by `Model.experiment`.

    Args:
        name: what it is called, in files, tables and figures.
        system: the closed loop whose weights are learned; its release and timing are those of an
            episode of training, and its release and integrator those of the evaluation, too.
        objective: the measure of an episode in training.
        conditions: what differs from one episode of training to another: numbers of the body or of
            the scenario, drawn anew in every generation (domain randomisation).
        episodes: how many episodes each candidate has, on average; more than one only
            under changing conditions.
        protocol: how what was learned is evaluated.
        search_offsets: where all there is to learn is a gain, it is searched for at these
            frequencies relative to ω_t [rad/s], by the mean fitness: at ω_t alone, or over those
            of the evaluation.

    Raises:
        TegotaeError: for a name that is no file's, a condition that body and scenario do not have
            or whose extremes make no body, or an episode that cannot be evaluated.

    Example:
        >>> from tegotae import Hopper
        >>> from tegotae.systems.recipe import recipe
        >>> experiment = recipe("ART").experiment(body=Hopper(mass_kg=0.12))
        >>> experiment.name, experiment.system.omega, experiment.controller.n_weights
        ('ART-rF-tphif-w8', 8.0, 96)
        >>> Experiment.from_document(experiment.document) == experiment
        True
        >>> from tegotae.parts.fields import replace
        >>> replace(experiment, {"height_m": 1.1}).system.release.height_m
        1.1
    """

    name: str
    system: System
    objective: Objective = field(default_factory=Fitness)
    conditions: tuple[Condition, ...] = ()
    episodes: int = 1
    protocol: Protocol = field(default_factory=Protocol)
    search_offsets: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        require_name(self.name)
        if not self.search_offsets:
            raise TegotaeError("search_offsets is empty; give at least one, such as 0")
        for offset in self.search_offsets:
            require_finite("a search offset", offset)
        require_count("episodes", self.episodes)
        if self.episodes > 1 and not self.conditions:
            raise TegotaeError(
                f"{self.name} has {self.episodes} episodes a candidate and no conditions in which "
                "they differ; they would all be the same one"
            )
        check_conditions(
            self.conditions,
            self.scenario,
            self.body,
            self.controller.oscillator,
            self.timing,
        )
        self.measure.check(self.timing)
        if self.omega is not None:
            varied = [
                condition.extremes for condition in self.conditions if condition.name == OMEGA
            ]
            omegas = cast(tuple[float, ...], varied[0] if varied else (self.omega,))
            self.objective.check_frequencies(min(omegas), max(omegas))

    def check(self) -> None:
        """Check, before long work starts, that there is something to train, on a body that can hop,
        and that all of it can be saved and read again.

        Raises:
            TegotaeError: if not.
        """
        if self.controller.n_weights == 0:
            raise TegotaeError(f"{self.name} has no weights to train")
        check_kept(self)
        self.body.check_release(self.system.release.height_m)
        check_releases(self.conditions, self.scenario, self.body)
        settle_s = getattr(self.objective, "settle_s", 0.5 * self.duration_s)
        check_passive(self.body, self.system.release.height_m, settle_s, self.timing.tick_s)

    @property
    def measure(self) -> Objective:
        """The objective as it applies here: a system without a frequency has none to follow."""
        return self.objective.without_frequency() if self.omega is None else self.objective

    @property
    def scenario(self) -> Scenario:
        """An episode of training: numbers."""
        return self.system.scenario()

    def evaluator(self, workers: int | None = None) -> EngineEvaluator:
        """Return the evaluator of candidate weights' fitness; it needs no workers."""
        varied = Randomization(self.conditions, self.body, self.scenario)
        return EngineEvaluator(self.system.rollout(), self.measure, varied, self.episodes)

    @property
    def duration_s(self) -> float:  # type: ignore[override]
        """Length of an episode of training [s]."""
        return self.timing.duration_s

    @property
    def searched_in(self) -> Sequence[Self]:
        """Experiments whose mean fitness a search for the gain maximises, one per frequency."""
        if self.omega is None:
            return (self,)
        return tuple(
            replace(self, {"omega": self.omega + offset}) for offset in self.search_offsets
        )

    def without_frequency(self) -> Self:
        """Return the experiment whose objective does not reward a frequency."""
        return replace(self, {"objective": self.objective.without_frequency()})

    @property
    def cot_unit(self) -> str:
        """The unit of CoT⁻¹ in which its objective measures it."""
        return self.objective.COT_UNIT

    @property
    def gains(self) -> np.ndarray:
        """Values of σ that a search tries [rad/(s N)]; on a hopper of any weight the same σ m g."""
        weight_n = getattr(self.body, "weight_n", None)
        return (
            GAINS * (Hopper().weight_n / weight_n) if self.body.limbs == 1 and weight_n else GAINS
        )

    @property
    def document(self) -> JsonObject:
        """The experiment as plain JSON values.

        Raises:
            TegotaeError: for a part that is not registered (`tegotae.register`).
        """
        return describe(self)

    @classmethod
    def from_document(cls, document: Mapping[str, Json]) -> Experiment:
        """Return the experiment of a document.

        Raises:
            TegotaeError: for a document of something else, or one that names a part that is not
                registered.
        """
        try:
            return restore(document, cls, "experiment")
        except UsersPartError as error:
            raise TegotaeError(f"the experiment {document.get('name')} {error}") from None
        except TegotaeError as error:
            raise TegotaeError(f"an experiment cannot be read: {error}") from None


def require_name(name: object) -> None:
    """Raise `TegotaeError` unless a text can name an experiment, and so a file.

    Example:
        >>> require_name("ART-rF-tphif-w8+hopf")
    """
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise TegotaeError(
            f"an experiment is called {name!r}; its name may have letters, digits and "
            ". _ + @ -, begins with a letter or a digit, and has 100 characters at most"
        )
