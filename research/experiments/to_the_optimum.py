"""Split the distance to the optimum: the best short law and the best learned ones beside it.

    python -m research.experiments.to_the_optimum results/learning

takes, of a study's folder of the kind `--scale learning` (docs/reproduction/learning.md), the best
runs of some models at ω_t = 4 rad/s: of those that hop on a limit cycle the one of highest training
fitness, and the one of highest CoT⁻¹ in the evaluation, which only the judge knows. On the limit
cycle of each the work per climbed metre is taken apart. Over a cycle the actuator's positive work
less its negative one is what the damper takes, so the absolute work of CoT⁻¹ is

    W / h = D / h + 2 W⁻ / h,

with the damper's loss D and the work W⁻ that the actuator takes back. An optimal gait at the same
hop frequency, and the best of all frequencies, stand beside it.

Written to `research/experiments/to_the_optimum` are `budget.csv`, `budget.md` and `forces.png`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from research.frame import Place, main, markdown_table, write_rows, write_text
from research.reproduction.commands.optimum import first_stance
from research.reproduction.figures.optimum import draw_optimum
from research.reproduction.folder import Folder
from research.reproduction.optimum import optimise
from research.reproduction.record import Record
from tegotae.analysis.orbit import NoLimitCycleError, Orbit, find_orbit
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.optimum import curve
from tegotae.parts.bodies import Hopper
from tegotae.systems.controller_file import SavedController

DOCS = Path(__file__).resolve().parents[2] / "docs"
MODELS = ("V-sector-w4", "load-w4", "latch-w4", "ART-rF-tphi-w4", "ARGT-rF-gF-tphi-w4")
BODY = Hopper()
_COLOURS = tuple(colour for colour in COLOURS if colour != "#000000")  # black is the optimum's


@dataclass(frozen=True)
class ToTheOptimum:
    """Split the distance to the optimum into parts."""

    study: Place
    """A study's folder."""
    out: Path = Path(__file__).parent / "to_the_optimum"
    """Folder of table and figure."""

    def run(self) -> None:
        """Find the cycles, and write."""
        records = {record.model: record for record in Folder(self.study).all()[0]}
        rows, forces = [], {}
        for name in MODELS:
            for criterion, run in runs_by_criterion(records[name]).items():
                orbit = orbit_of(records[name], run)
                label = f"{name}, {criterion}"
                if orbit is not None:
                    rows.append({"controller": label, "run": run, **budget_of(orbit)})
                    forces[label] = first_stance(orbit)
        best = curve()
        for omega in (4.0, float(best["omega"][np.nanargmax(best["cot_inverse"])])):
            row, stance = optimal(omega)
            rows.append({"controller": f"optimum at {omega:.3g} rad/s", "run": "", **row})
            forces[rows[-1]["controller"]] = stance
        write_rows(self.out / "budget.csv", rows, digits=5)
        budgets = pd.read_csv(self.out / "budget.csv")
        write_text(self.out / "budget.md", markdown(budgets))
        with styled():
            save_figure(figure(budgets, forces), self.out / "forces.png")
        print(markdown(budgets))


def runs_by_criterion(record: Record) -> dict[str, int]:
    """Return the run of highest fitness, and that of highest CoT⁻¹ at ω_t in the evaluation."""
    at_omega_t = len(record.omega) // 2
    cot = np.nan_to_num(record.episodes["cot_inverse"][:, at_omega_t], nan=-1.0)
    indices = {"by fitness": int(np.argmax(record.best_fitness)), "best": int(np.argmax(cot))}
    if record.experiment.is_searched or len(set(indices.values())) == 1:
        return {"by fitness": indices["by fitness"]}
    return indices


def orbit_of(record: Record, run: int) -> Orbit | None:
    """Return the limit cycle of a run at ω_t, or None if it has none."""
    try:
        return find_orbit(SavedController(record.experiment.system, record.weights[run]))
    except NoLimitCycleError:
        return None


def budget_of(orbit: Orbit) -> dict[str, float]:
    """Return the work per climbed metre of a limit cycle, by its parts."""
    power = orbit.actuator_force_n * orbit.velocity_m_per_s
    climb = float((orbit.apex_height_m - BODY.rest_length_m).sum())
    absolute, taken = (
        float(np.trapezoid(values, orbit.time_s))
        for values in (np.abs(power), np.maximum(-power, 0.0))
    )
    return budget(2.0 * np.pi * orbit.hops / orbit.period_s, climb, absolute, taken)


def budget(rate: float, climb_m: float, work_j: float, taken_back_j: float) -> dict[str, float]:
    """Return a cycle's hop rate, CoT⁻¹ and energies per climbed metre."""
    return {
        "hop_rate_rad_per_s": rate,
        "cot_inverse_m_per_j": climb_m / work_j,
        "work_j_per_m": work_j / climb_m,
        "damper_j_per_m": (work_j - 2.0 * taken_back_j) / climb_m,
        "taken_back_twice_j_per_m": 2.0 * taken_back_j / climb_m,
    }


def optimal(omega: float) -> tuple[dict[str, float], dict[str, np.ndarray]]:
    """Return the best gait of one hop that optimisation finds: its budget and its stance."""
    gait = optimise(BODY, omega)
    height, force = np.append(gait.height_m[0], 0.0), gait.force_n[0]
    # The force is constant in an interval, and no interval has a turn of the motion.
    work = force * np.diff(height)
    climb = gait.lift_off_m_per_s[0] ** 2 / (2.0 * BODY.gravity_m_per_s2)
    row = budget(omega, climb, float(np.abs(work).sum()), float(-work[work < 0.0].sum()))
    return row, {"time_s": gait.time_s[0], "force_n": force}


def markdown(budgets: pd.DataFrame) -> str:
    """Return the budgets as Markdown, one row per gait."""
    head = ["gait", "hop rate [rad/s]", "CoT⁻¹ [m/J]", "work [J/m]", "damper [J/m]"]
    lines = [[*head, "taken back, twice [J/m]"]]
    for row in budgets.to_dict("records"):
        numbers = [f"{row[name]:.3f}" for name in list(budgets)[2:]]
        lines.append([str(row["controller"]), *numbers])
    return markdown_table(lines)


def figure(budgets: pd.DataFrame, forces: dict[str, dict[str, np.ndarray]]) -> Figure:
    """Draw CoT⁻¹ over hop rate beside the optimum, and the forces over a stance."""
    page = new_figure(PAGE_IN, 3.6)
    left_axes, right_axes = page.subplots(1, 2)
    draw_optimum(left_axes, curve())
    for i, row in enumerate(budgets.to_dict("records")):
        name = str(row["controller"])
        colour, stance = _COLOURS[i % len(_COLOURS)], forces[name]
        if name.startswith("optimum"):
            style = {"color": "black", "ls": "--" if i % 2 else "-", "zorder": 1.0}
        else:
            style = {"color": colour}
            left_axes.plot(row["hop_rate_rad_per_s"], row["cot_inverse_m_per_j"], "o", color=colour)
        right_axes.plot(stance["time_s"], stance["force_n"], label=name, lw=1.0, **style)
    left_axes.set(
        xlim=(2.8, 5.0), ylim=(0.8, 1.35), xlabel="hop rate [rad/s]", ylabel="CoT⁻¹ [m/J]"
    )
    right_axes.set(xlim=(0.0, 0.65), xlabel="time since touchdown [s]", ylabel="actuator force [N]")
    page.legend(loc="outside lower center", ncols=3, fontsize=6)
    return page


if __name__ == "__main__":
    main(ToTheOptimum)
