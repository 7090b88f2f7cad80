"""Another simulator: controllers run where they were trained, on an environment."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from tegotae._support.errors import TegotaeError, require_count
from tegotae.envs.env_spec import EnvSpec, settings_of
from tegotae.parts.bodies import Body
from tegotae.questions.answer import Answer, RecordedRun, columns
from tegotae.questions.options import changes
from tegotae.questions.task import Task
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import EnvObjective, Hopping
from tegotae.training.environments.replay import Replay, lasting, replay

if TYPE_CHECKING:
    from tegotae.analysis.generalisation.disturbances import Tested


@dataclass(frozen=True, kw_only=True)
class EnvironmentSimulation:
    """Play an episode where a controller was trained, in another simulator."""

    duration_s: float
    """Length of the episode [s]."""


@dataclass(frozen=True, kw_only=True)
class EnvironmentEvaluation:
    """Play episodes where controllers were trained, in another simulator."""

    omega: tuple[float, ...]
    """Frequencies [rad/s]."""
    starts: int = 32
    """Episodes of each run, where the environment has noise."""
    settings: tuple[str, ...] = ()
    """Settings of the environment that differ from the training: NAME=VALUE, such as noise=0.02 or
    mass_factor=1.2."""


@dataclass(frozen=True, kw_only=True)
class EnvironmentTraining:
    """An episode of training in another simulator, and the fitness."""

    duration_s: float
    """Duration of a training episode [s]."""
    cot_only: bool = False
    """Use CoT⁻¹ alone as the fitness, without ΔΩ."""
    episodes_per_candidate: int
    """Number of episodes per candidate."""
    objective: EnvObjective

    @classmethod
    def options_of(cls, experiment: EnvExperiment) -> EnvironmentTraining:
        """An experiment's own values."""
        return cls(
            duration_s=experiment.duration_s,
            episodes_per_candidate=experiment.episodes,
            objective=experiment.objective,
        )

    def applied(self, experiment: EnvExperiment) -> EnvExperiment:
        """The experiment with what differs from its own; unless it is given, the share of an
        episode that is left to settle stays.

        Raises:
            TegotaeError: for what does not fit together.
        """
        settings = changes(self.objective, experiment.objective)
        if self.cot_only:
            if not isinstance(self.objective, Hopping):
                raise TegotaeError("--cot-only belongs to the fitness hopping")
            settings["follow_omega"] = False
        objective = lasting(experiment, self.duration_s).objective
        return dataclasses.replace(
            experiment,
            duration_s=self.duration_s,
            episodes=self.episodes_per_candidate,
            objective=dataclasses.replace(objective, **settings),  # type: ignore[type-var]
        )


_SHARE, _POSITIVE = (0.0, 1.0), (0.0, math.inf)
OF_EPISODES = columns(
    ("fitness", "fitness"),
    ("return", "return, sum of the rewards"),
    ("lasted", "share of the episode that it lasted", "", _SHARE),
    ("distance_m", "distance", "m"),
    ("speed_m_per_s", "speed", "m/s"),
    ("work_j", "work of the actuators", "J", _POSITIVE),
    ("cost_of_transport", "cost of transport", "", _POSITIVE),
    ("stride_hz", "rate of the first oscillator", "Hz"),
    ("duty", "share of time on the ground", "", _SHARE),
    ("hops", "hops", "", _POSITIVE),
    ("apex_m", "height of the late apexes", "m", _POSITIVE),
    ("cot_inverse", "CoT⁻¹", "m/J", _POSITIVE),
    ("limit_cycle_period", "period of the limit cycle", "hops", _POSITIVE),
    ("w_peak", "peak of the spectrum", "rad/s", _POSITIVE),
    ("t0_s", "transient T0", "s", _POSITIVE),
)
"""What is measured of an episode; what an environment does not say is left out."""


@dataclass(frozen=True)
class EnvironmentTask(Task):
    """Controllers that were trained in another simulator."""

    what = "runs in another simulator"

    @cached_property
    def experiment(self) -> EnvExperiment:
        """The experiment in which they were trained."""
        return EnvExperiment.of(self.runs)

    def on(self, body: Body) -> EnvironmentTask:
        raise TegotaeError(f"{self.name} was trained on an environment, and has its body there")

    def simulate_options(self) -> EnvironmentSimulation:
        """The options of an episode."""
        return EnvironmentSimulation(duration_s=self.experiment.duration_s)

    def simulate(self, options: EnvironmentSimulation) -> RecordedRun:
        """One episode."""
        experiment = lasting(self.experiment, options.duration_s)
        (played,) = replay(experiment, [self.weights])
        why = played.why_on_ground()
        return RecordedRun(
            name=self.name,
            outcome=f"an episode on {experiment.spec.env}",
            raw=played,
            numbers=played.numbers(),
            columns=OF_EPISODES,
            table=lambda: _series(played),
            settings=options,
            remarks=(f"It {why}.",) if why else (),
        )

    def evaluate_options(self) -> EnvironmentEvaluation:
        """The options of an evaluation."""
        experiment = self.experiment
        omegas = experiment.omegas or (experiment.wiring.omega,)
        return EnvironmentEvaluation(omega=tuple(omega for omega in omegas if omega is not None))

    def alike(self, options: EnvironmentEvaluation) -> Mapping[str, Any]:
        spec = self.experiment.spec
        return {"environment": spec.env, "its settings": spec.settings}

    def evaluate(self, options: EnvironmentEvaluation) -> Answer:
        """Episodes of every run, frequency and start."""
        require_count("starts", options.starts)
        experiment, rows = self.experiment, []
        changed = dict(experiment.spec.settings) | settings_of(options.settings)
        spec = EnvSpec(env=experiment.spec.env, settings=tuple(changed.items()))
        varied = not spec.is_model or spec.model_settings.noise > 0.0
        for omega in options.omega or (None,):
            wiring = dataclasses.replace(experiment.wiring, omega=omega)
            there = dataclasses.replace(experiment, spec=spec, wiring=wiring)
            for start in range(options.starts if varied else 1):
                played = replay(there, self.runs.weights, seed=experiment.seed + start)
                rows += [
                    {"run": run, "omega": omega, "start": start, **episode.numbers()}
                    for run, episode in zip(self.runs.labels, played, strict=True)
                ]
        said = (
            "Mean over runs [95 % interval]; the mean of a run is over its starts. – is undefined"
        )
        if "hops" in rows[0]:
            said += ": without a limit cycle there is neither CoT⁻¹ nor a transient"
        return self.answer(
            rows,
            OF_EPISODES,
            options,
            groups=("controller", "omega"),
            remarks=(f"{said}. * means that some runs are.",),
        )

    def tested(self, starts: int) -> Tested:
        from tegotae.analysis.generalisation.on_environment import ModelUnderTest

        return ModelUnderTest.of(self.runs, starts)


def _series(played: Replay) -> dict[str, Any]:
    """What was observed and done, rewards, phases; a row a step."""
    episode, experiment = played.episode, played.experiment
    driven = [limb.entries[0] for limb in experiment.wiring.limbs]
    return {
        "time_s": episode.time_s,
        **{name: episode[name] for name in episode.names},
        **{f"{limb}_phase_rad": episode.phase_rad[:, i] for i, limb in enumerate(driven)},
        **{f"action_{i}": episode.action[:, i] for i in range(len(experiment.wires.low))},
        "reward": episode.reward,
    }
