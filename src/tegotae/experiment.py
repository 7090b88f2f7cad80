"""An experiment: what is trained, on what, by what measure, and how it is then evaluated."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tegotae.bodies import Body, Hopper
from tegotae.controller import Controller
from tegotae.descriptions import EditedPartError, check_kept, describe, restore
from tegotae.errors import TegotaeError, require_count, require_finite
from tegotae.evaluation import Protocol
from tegotae.integrators import Integrator, PredictorCorrector
from tegotae.limits import MOST_M, MOST_RAD_PER_S
from tegotae.loop import check_senses
from tegotae.registry import CODE
from tegotae.rollout import Engine, Timing
from tegotae.training.fitness import EPISODE, Fitness
from tegotae.training.judge import EngineJudge
from tegotae.training.objective import Objective
from tegotae.training.variety import Variety
from tegotae.world import Condition, Scenario
from tegotae.world.checks import check_posture, check_rhythm
from tegotae.world.draws import check_conditions, check_releases

GAINS = np.linspace(0.1, 12.0, 240)
"""Values of σ that are tried on the hopper [rad/(s N)]."""
RELEASE_M = 1.2
"""Height of the paper's release [m]."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+@-]{0,99}")


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """Everything that a training and an evaluation are about, but for how and how long is learned.

    Trainings of any algorithm, tuning and the study are made of experiments; the 218 models of the
    paper make theirs by `Model.experiment`.

    Args:
        name: what it is called, in files, tables and figures.
        controller: the structure whose weights are learned.
        omega: prescribed frequency ω_t [rad/s]; None without an oscillator.
        body: what is driven.
        release_m: height of the release in training [m], at rest.
        phase_rad: phases of the oscillators at that release [rad], one, or one a limb.
        posture: what else the body's release takes, pairs of name and number, such as
            (("pitch_rad", 0.1),) for a bar.
        conditions: what differs from one episode of training to another: numbers of the body or of
            the scenario, drawn anew in every generation (`tegotae.training.variety`).
        episodes: how many episodes each candidate is judged by, on average; more than one only
            under changing conditions.
        timing: the episode of training.
        integrator: how an episode of training is advanced; `Hold()` holds the controller over each
            tick, as a robot does. The evaluation is in continuous time all the same.
        fitness: by what measure an episode is judged in training.
        protocol: how what was learned is evaluated.

    Raises:
        TegotaeError: for a name that is no file's, an oscillator without a frequency or the other
            way round, a signal that nobody provides, a height that is not positive, phases of other
            limbs, a posture that the body does not take, a condition that body and scenario do not
            have or whose extremes make no body, a control period too long for body or oscillator,
            or an episode that cannot be judged.

    Example:
        >>> from tegotae.models import find
        >>> experiment = find("ART").experiment(body=Hopper(mass_kg=0.12))
        >>> experiment.name, experiment.omega, experiment.controller.n_weights
        ('ART-rF-tphif-w8', 8.0, 96)
        >>> Experiment.of(experiment.document) == experiment
        True
    """

    name: str
    controller: Controller
    omega: float | None = None
    body: Body = field(default_factory=Hopper)
    release_m: float = RELEASE_M
    phase_rad: float | tuple[float, ...] = 0.0
    posture: tuple[tuple[str, float], ...] = ()
    conditions: tuple[Condition, ...] = ()
    episodes: int = 1
    timing: Timing = EPISODE
    integrator: Integrator = field(default_factory=PredictorCorrector)
    fitness: Objective = field(default_factory=Fitness)
    protocol: Protocol = field(default_factory=Protocol)

    def __post_init__(self) -> None:
        require_name(self.name)
        if self.controller.oscillator is None and self.omega is not None:
            raise TegotaeError(
                f"{self.name} has a frequency ({self.omega:g} rad/s) but no oscillator; "
                "its omega must be None"
            )
        if self.controller.oscillator is not None and self.omega is None:
            raise TegotaeError(f"{self.name} has an oscillator; give it an omega, such as 8 rad/s")
        if self.omega is not None:
            require_finite("omega", self.omega, above=0.0, most=MOST_RAD_PER_S)
        require_finite("release_m", self.release_m, above=0.0, most=MOST_M)
        check_senses(self.controller, self.body)
        self._check_start()
        self.body.check_tick(self.timing.tick_s)
        self._check_conditions()
        self.fitness.check(self.timing)

    def _check_start(self) -> None:
        phases = np.atleast_1d(self.phase_rad)
        for phase in phases:
            require_finite("phase_rad", phase)
        if isinstance(self.phase_rad, tuple) and not 1 < self.body.limbs == len(phases):
            raise TegotaeError(
                f"{self.name} starts {len(phases)} limbs, each at a phase of its own; its body has "
                f"{self.body.limbs}"
            )
        check_posture(self.body, self.scenario)
        check_rhythm(
            self.controller.oscillator,
            self.scenario,
            self.timing.tick_s,
            self.timing.duration_s,
        )
        for name, value in self.posture:
            require_finite(name, value)

    def _check_conditions(self) -> None:
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
            self.timing.tick_s,
            self.timing.duration_s,
        )

    def check(self) -> None:
        """See, before long work starts, that there is something to train, on a body that can hop,
        and that all of it can be saved and read again.

        Raises:
            TegotaeError: if not.
        """
        if self.controller.n_weights == 0:
            raise TegotaeError(f"{self.name} has no weights to train")
        check_kept(self)
        self.body.check_release(self.release_m)
        check_releases(self.conditions, self.scenario, self.body)

    @property
    def measure(self) -> Objective:
        """The fitness as it applies here: without a frequency there is none to follow."""
        return self.fitness.without_frequency() if self.omega is None else self.fitness

    @property
    def scenario(self) -> Scenario:
        """An episode of training: numbers."""
        by_limb = isinstance(self.phase_rad, tuple)
        phase = np.array(self.phase_rad)[:, None] if by_limb else self.phase_rad
        posture = dict(self.posture)
        return Scenario.of(self.omega, height_m=self.release_m, phase_rad=phase, posture=posture)

    def judge(self, workers: int | None = None) -> EngineJudge:
        """Who says in training how good weights are; the engine needs no worker processes."""
        engine = Engine(controller=self.controller, integrator=self.integrator, timing=self.timing)
        varied = Variety(self.conditions, self.body, self.scenario)
        return EngineJudge(engine, self.measure, varied, self.episodes)

    @property
    def is_searched(self) -> bool:
        """Whether all there is to learn is a constant gain σ, which a search finds."""
        return self.controller.has_a_gain_alone

    @property
    def cot_unit(self) -> str:
        """The unit of CoT⁻¹ in which its fitness measures it."""
        return self.fitness.COT_UNIT

    @property
    def gains(self) -> np.ndarray:
        """Values of σ that a search tries [rad/(s N)]."""
        return GAINS

    @property
    def document(self) -> dict[str, Any]:
        """The experiment as plain JSON values.

        Raises:
            TegotaeError: for a part that is not registered (`tegotae.register`).
        """
        document = describe(self)
        # Those that start as they always did are described as before there was another start.
        for name in ("phase_rad", "posture", "conditions"):
            if not document[name]:
                del document[name]
        if self.episodes == 1:
            del document["episodes"]
        if self.integrator == PredictorCorrector():
            del document["integrator"]
        return document

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Experiment:
        """The experiment of a document.

        Raises:
            TegotaeError: for a document of something else, or one that names a part that is not
                registered.
        """
        try:
            return restore(document, cls, "experiment")
        except EditedPartError as error:
            raise TegotaeError(f"the experiment {document.get('name')} {error}") from None
        except KeyError as error:
            raise TegotaeError(f"an experiment has no entry {error}") from None
        except (TypeError, ValueError, OverflowError) as error:
            raise TegotaeError(f"an experiment cannot be read: {error}") from None


def require_name(name: Any) -> None:
    """Raise `TegotaeError` unless a name can be an experiment's, and so a file's.

    Example:
        >>> require_name("ART-rF-tphif-w8+hopf")
    """
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise TegotaeError(
            f"an experiment is called {name!r}; its name may have letters, digits and "
            ". _ + @ -, begins with a letter or a digit, and has 100 characters at most"
        )


def differing(found: Any, wanted: Any) -> list[str]:
    """Names of what differs between two documents, such as `fitness.work` or `code of MyTerm`.

    Example:
        >>> differing({"seeds": 1, "body": {"mass_kg": 1}}, {"seeds": 1, "body": {"mass_kg": 2}})
        ['body.mass_kg']
        >>> differing({"kind": "MyTerm", "sha256": "a0"}, {"kind": "MyTerm", "sha256": "b1"})
        ['code of MyTerm']
    """
    names = _differing(_without_code(found), _without_code(wanted))
    theirs, ours = dict(_codes(found)), dict(_codes(wanted))
    edited = [each for each in {**theirs, **ours} if theirs.get(each) != ours.get(each)]
    # The code of a part that one of them lacks is not worth a word beside that.
    return names + [f"code of {x}" for x in edited if not names or (x in theirs and x in ours)]


def _codes(document: Any) -> Iterator[tuple[str, str]]:
    """The hashes of the code in a document, by what they are of."""
    if isinstance(document, list):
        for each in document:
            yield from _codes(each)
    if not isinstance(document, Mapping):
        return
    code = document.get(CODE)
    if isinstance(code, Mapping):
        yield from ((str(what), str(each)) for what, each in code.items())
    elif code is not None:
        names = (document.get(key) for key in ("kind", "name", "algorithm"))
        yield next((str(each) for each in names if each), "a part"), str(code)
    for each in document.values():
        yield from _codes(each)


def _without_code(document: Any) -> Any:
    if isinstance(document, list):
        return [_without_code(each) for each in document]
    if not isinstance(document, Mapping):
        return document
    return {name: _without_code(each) for name, each in document.items() if name != CODE}


def _differing(found: Any, wanted: Any, name: str = "") -> list[str]:
    if found == wanted:
        return []
    if isinstance(found, list) and isinstance(wanted, list) and len(found) == len(wanted):
        inside = (_differing(a, b, name) for a, b in zip(found, wanted, strict=True))
        return list(dict.fromkeys(each for names in inside for each in names))
    if not isinstance(found, Mapping) or not isinstance(wanted, Mapping):
        return [name]
    if name.endswith("controller") or found.get("kind") != wanted.get("kind"):
        return [name]
    names = [
        each
        for key in {**wanted, **found}
        for each in (
            _differing(found[key], wanted[key], f"{name}.{key}" if name else key)
            if key in found and key in wanted
            else [f"{name}.{key}" if name else key]
        )
    ]
    return [each.removeprefix("experiment.") for each in names]
