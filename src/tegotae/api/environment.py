"""Another simulator: controllers run where they were trained, on an environment."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Unpack

from tegotae._support.errors import TegotaeError, require_count
from tegotae.api.controller import LoadedController, MetricOptions, Subject
from tegotae.api.evaluations import EvaluationTable
from tegotae.api.parameters import HIDDEN, Values, changes, check_types, filled
from tegotae.api.results import Animation, MatplotlibFigure, Recording, Table
from tegotae.envs.env_spec import EnvSpec, settings_of
from tegotae.envs.wiring import read_by
from tegotae.measures.robots import ROBOTS
from tegotae.parts.bodies import Body
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import Hopping
from tegotae.training.environments.replay import Replay, lasting, replay

if TYPE_CHECKING:
    from tegotae.analysis.generalisation.disturbances import Tested


_ON_ENGINE = (
    *("height_m", "tick_s", "hold", "vary", "drop_m", "work", "tuned_over"),
    *("sector_start_rad", "sector_duration_s", "newtons_per_feedback"),
)
"""Options of a training that belong to this package's engine."""


def environment_defaults(experiment: EnvExperiment) -> Values:
    """Return the experiment's own values of the options of a training.

    Args:
        experiment: the experiment.
    """
    return {
        "": experiment.name,
        "duration_s": experiment.duration_s,
        "episodes_per_candidate": experiment.episodes,
        "fitness": experiment.objective,
        **dict.fromkeys(_ON_ENGINE, HIDDEN),
    }


def adjusted_on_environment(experiment: EnvExperiment, options: Mapping[str, Any]) -> EnvExperiment:
    """Return an experiment with other values; the share of an episode for settling stays.

    Args:
        experiment: the experiment.
        options: options of `train` that differ; None stands for the experiment's own.

    Raises:
        TegotaeError: for an option that it does not have, or values that do not fit together.
    """
    values = filled(options, environment_defaults(experiment))
    settings = changes(values.fitness, experiment.objective)
    if options.get("cot_only"):
        if not isinstance(values.fitness, Hopping):
            raise TegotaeError("cot_only belongs to the fitness hopping")
        settings["follow_omega"] = False
    objective = lasting(experiment, values.duration_s).objective
    return dataclasses.replace(
        experiment,
        duration_s=values.duration_s,
        episodes=values.episodes_per_candidate,
        objective=dataclasses.replace(objective, **settings),  # type: ignore[type-var]
    )


class EpisodeEvaluation(MetricOptions, total=False):
    """Options of an evaluation in another simulator."""

    omega: Annotated[Sequence[float] | None, "frequencies [rad/s]"]
    command: Annotated[
        Sequence[str] | Sequence[float] | Path | None,
        "of a robot that takes commands: forward, left [m/s], yaw rate [rad/s] and, if it is to "
        "turn to one, a heading [rad]; or a file FILE.csv of them over time",
    ]
    starts: Annotated[int, "episodes of each run, where the environment has noise", 32]
    settings: Annotated[
        Sequence[str],
        "settings of the environment that differ from the training: NAME=VALUE, such as noise=0.02 "
        "or mass_factor=1.2",
        (),
    ]


@dataclass(frozen=True)
class EnvironmentController(LoadedController):
    """Controllers that were trained in another simulator."""

    description = "runs in another simulator"
    catalogue = ROBOTS

    @cached_property
    def experiment(self) -> EnvExperiment:
        """The experiment in which they were trained."""
        return EnvExperiment.from_controller(self.runs)

    def on(self, body: Body) -> EnvironmentController:
        raise TegotaeError(f"{self.name} was trained on an environment, and has its body there")

    def defaults(self) -> Values:
        experiment = self.experiment
        omegas = experiment.omegas or (experiment.wiring.omega,)
        return {
            "duration_s": experiment.duration_s,
            "omega": tuple(omega for omega in omegas if omega is not None),
        }

    @check_types
    def simulate(
        self,
        *,
        duration_s: float | None = None,
        command: Sequence[str] | Sequence[float] | Path | None = None,
    ) -> Recording:
        """Play an episode where a controller was trained, in another simulator.

        Args:
            duration_s: length of the episode [s].
            command: of a robot that takes commands: forward, left [m/s], yaw rate [rad/s] and, if
                it is to turn to one, a heading [rad]; or a file FILE.csv of them over time, with
                the columns `time_s`, `forward_m_per_s`, `left_m_per_s`, `yaw_rate_rad_per_s` and
                `heading_rad`.

        Raises:
            TegotaeError: for a command of a robot that takes none, or one that is none.
        """
        options = filled(locals(), self.defaults())
        experiment = _commanded(lasting(self.experiment, options.duration_s), options.command)
        (played,) = replay(experiment, [self.weights])
        reason, title = played.why_on_ground(), f"an episode on {experiment.spec.env}"
        return Recording(
            name=self.name,
            title=title,
            raw=played,
            numbers=played.numbers(),
            headings={metric.name: metric.heading for metric in ROBOTS.metrics()},
            rows=lambda: _series(played),
            settings=vars(options),
            notes=(f"It {reason}.",) if reason else (),
            draw=lambda: _figures(played, f"{self.name}: {title}"),
            film=lambda: _animation(played),
            window=lambda: _view(played),
        )

    @check_types
    def evaluate(
        self, *others: Subject | LoadedController, **options: Unpack[EpisodeEvaluation]
    ) -> Table:
        """Play episodes where controllers were trained, in another simulator.

        Args:
            others: further controllers.

        Raises:
            TegotaeError: for values that cannot be, or controllers without a measure in common.
        """
        return self._evaluated(others, options)

    @check_types
    def compare(
        self, *others: Subject | LoadedController, **options: Unpack[EpisodeEvaluation]
    ) -> Table:
        """Compare episodes where controllers were trained, in another simulator.

        Args:
            others: controllers that are compared with this one.

        Raises:
            TegotaeError: for values that cannot be, or controllers without a measure in common.
        """
        return self._compared(others, options)

    def _shared(self, options: Any) -> Mapping[str, Any]:
        spec = self.experiment.spec
        return {"environment": spec.env, "its settings": spec.settings}

    def _measured(self, options: Any) -> EvaluationTable:
        require_count("starts", options.starts)
        experiment = _commanded(self.experiment, options.command)
        rows, metrics = list[dict[str, Any]](), self._metrics(options.metric)
        changed = dict(experiment.spec.settings) | settings_of(options.settings)
        spec = EnvSpec(env=experiment.spec.env, settings=tuple(changed.items()))
        varied = not spec.is_model or spec.model_settings.noise > 0.0
        for omega in options.omega or (None,):
            wiring = dataclasses.replace(experiment.wiring, omega=omega)
            tested = dataclasses.replace(experiment, spec=spec, wiring=wiring)
            for start in range(options.starts if varied else 1):
                played = replay(tested, self.runs.weights, seed=experiment.seed + start)
                rows += [
                    {"run": run, "omega": omega, "start": start, **episode.numbers(metrics)}
                    for run, episode in zip(self.runs.labels, played, strict=True)
                ]
        note = (
            "Mean over runs [95 % interval]; the mean of a run is over its starts. – is undefined"
        )
        if "hops" in rows[0]:
            note += ": without a limit cycle there is neither CoT⁻¹ nor a transient"
        return self._measurements(
            rows,
            metrics,
            options,
            shows_all=True,
            groups=("controller", "omega"),
            notes=(f"{note}. * means that some runs are.",),
        )

    def tested(self, starts: int) -> Tested:
        from tegotae.analysis.generalisation.on_environment import EnvironmentUnderTest

        return EnvironmentUnderTest.from_runs(self.runs, starts)


def _commanded(experiment: EnvExperiment, command: Sequence[float] | Path | None) -> EnvExperiment:
    """Return an experiment whose robot has another command; its own for None."""
    if command is None:
        return experiment
    if "commanded_speed" not in read_by(experiment.controller):
        raise TegotaeError(
            f"{experiment.name} takes no command; give one to a law that does, such as raibert"
        )
    words = [command] if isinstance(command, Path) else [*command]
    try:
        value = [float(x) for x in words]  # type: ignore[arg-type]
    except (TypeError, ValueError):
        value = " ".join(map(str, words))
    settings = dict(experiment.spec.settings) | {"command": value}
    spec = dataclasses.replace(experiment.spec, settings=tuple(settings.items()))
    _ = spec.model_settings
    return dataclasses.replace(experiment, spec=spec)


def _figures(played: Replay, title: str) -> dict[str, MatplotlibFigure]:
    """Draw the gait like a recording's if its hops can be measured, and loads and phases."""
    from tegotae.figures.recording import recording_figure
    from tegotae.figures.rollout import episode_figure
    from tegotae.figures.style import literal_text

    measured, rest_length_m = played.episode.hopping, played.experiment.wiring.rest_length_m
    title = literal_text(title)
    loads = {"loads": episode_figure(played, note=title)}
    if measured is None or rest_length_m is None:
        return loads
    return {"gait": recording_figure(measured, rest_length_m=rest_length_m, note=title), **loads}


def _animation(played: Replay) -> Animation:
    from tegotae.figures.animation import film_animation

    return film_animation(played)


def _view(played: Replay) -> None:
    from tegotae.figures.viewer import view

    view(played)


def _series(played: Replay) -> dict[str, Any]:
    """Return observations, phases, actions and rewards, one row per step."""
    episode, experiment = played.episode, played.experiment
    driven = [limb.entries[0] for limb in experiment.wiring.limbs]
    return {
        "time_s": episode.time_s,
        **{name: episode[name] for name in episode.names},
        **{f"{limb}_phase_rad": episode.phase_rad[:, i] for i, limb in enumerate(driven)},
        **{f"action_{i}": episode.action[:, i] for i in range(len(experiment.wires.low))},
        "reward": episode.reward,
    }
