"""`tegotae wiring baseline`: the vanilla controller on an environment, σ and ω swept."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import tyro

from tegotae._support.errors import TegotaeError
from tegotae._support.files import check_folder
from tegotae.cli.console import print_rows
from tegotae.cli.env_options import EnvOptions

if TYPE_CHECKING:
    from tegotae.training.environments.baseline import VanillaSweep
    from tegotae.training.environments.experiment import EnvExperiment

_SHARES = np.linspace(0.5, 1.5, 7)
"""Frequencies that are tried by default, over the wiring's."""
_AUTO = tyro.conf.arg(help_behavior_hint="(default: seven, 0.5 to 1.5 times --omega)")
_MEASURE = tyro.conf.arg(help_behavior_hint="(default: as tegotae train)")
_FOLDER = tyro.conf.arg(help_behavior_hint="(default: runs/ENV-vanilla)")


@dataclass(frozen=True, kw_only=True)
class WiringBaseline(EnvOptions):
    """Sweep gain and frequency of the vanilla controller on an environment: the baseline for
    learned controllers.

    The command writes a map of the fitness, as a picture and a table, and the best controller.
    """

    model: str = "V-sector-w8"
    """A pure V model, whose only weight is σ."""
    frequencies: Annotated[tuple[float, ...], _AUTO] = ()
    """Frequencies ω [rad/s]; those of --omega if it names several."""
    duration: float = 12.0
    """Duration of an episode [s]."""
    fitness: Annotated[str | None, _MEASURE] = None
    """Fitness: hopping, return, or FILE.py:FUNCTION."""
    out: Annotated[Path | None, _FOLDER] = None
    """Folder for the map and the best controller."""

    def run(self) -> None:
        """Sweep, write and print."""
        if self.env is None:
            raise TegotaeError("no environment is named; give --env, such as --env my_leg.xml")
        from tegotae.figures.maps import vanilla_sweep_figure, vanilla_sweep_table
        from tegotae.figures.style import literal, save_figure, write_tables

        experiment = self.experiment_of(
            self.model, duration_s=self.duration, fitness=self.fitness, hopping={}
        )
        experiment.check()
        from tegotae.training.environments.baseline import sweep_vanilla

        out = Path("runs") / f"{self.called}-vanilla" if self.out is None else self.out
        check_folder(out)
        assert experiment.omega is not None
        omega = (
            self.frequencies
            or experiment.omegas
            or tuple(float(f"{x:.3g}") for x in _SHARES * experiment.omega)
        )
        sweep = sweep_vanilla(experiment, omega, self.workers)
        named = "fitness" if self.fitness is None else f"fitness: {self.fitness}"
        figure = vanilla_sweep_figure(sweep, fitness=literal(named))
        written = [save_figure(figure, out / "map.png")]
        written += write_tables(written[0], {"": vanilla_sweep_table(sweep)})
        written.append(_save_best(experiment, sweep, out))
        _print(sweep)
        print("wrote " + ", ".join(map(str, written)))


def _save_best(experiment: EnvExperiment, sweep: VanillaSweep, out: Path) -> Path:
    from tegotae.training.evolution import SEARCH
    from tegotae.training.folder import save_controller
    from tegotae.training.learner import LearnedController

    row, column = sweep.best
    wiring = dataclasses.replace(experiment.wiring, omega=float(sweep.omega[column]))
    found = {"seed": 0, "best_fitness": float(sweep.fitness[row, column]), "ended": SEARCH}
    outcome = {**found, "generations": 0, "best_generation": 0}
    return save_controller(
        out,
        dataclasses.replace(experiment, wiring=wiring, omegas=(), episodes=1),
        LearnedController(experiment.controller, sweep.sigma[[row]], outcome),
        {"swept": {"sigma": sweep.sigma.tolist(), "omega": sweep.omega.tolist()}},
        {},
    )


def _print(sweep: VanillaSweep) -> None:
    best = np.argmax(sweep.fitness, axis=0)
    print_rows(
        ("ω [rad/s]", "best σ", "fitness", "fitness at σ = 0", "failed"),
        (
            (
                f"{omega:g}",
                f"{sweep.sigma[best[i]]:.3g}",
                f"{sweep.fitness[best[i], i]:.4f}",
                f"{sweep.fitness[0, i]:.4f}",
                f"{sweep.failed[:, i].mean():.0%}",
            )
            for i, omega in enumerate(sweep.omega)
        ),
    )
    row, column = sweep.best
    print(
        f"best: σ {sweep.sigma[row]:.3g} rad/(s N) at ω {sweep.omega[column]:g} rad/s, fitness "
        f"{sweep.fitness[row, column]:.4f}"
    )
    if np.isfinite(sweep.cot_inverse).any() and not np.nanmax(sweep.cot_inverse) > 0.0:
        print(
            "Nothing hops: CoT⁻¹ is 0 everywhere. Enlarge the pushes, release it higher "
            "(--settings release_m=0.1), or use --fitness return."
        )
    if row == 0:
        print(
            "No gain is better than zero: feedback does not help the bare rhythm. Check rests and "
            "pushes of the wiring first."
        )
    elif column in (0, len(sweep.omega) - 1) and len(sweep.omega) > 1:
        print("The best ω is the last one tried: --frequencies beyond it may do better.")
