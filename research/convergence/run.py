"""Compare integrators and control periods: apex errors against an adaptive solver.

    python -m research.convergence.run vanilla
    python -m research.convergence.run laws

writes `convergence.csv` (every case), `convergence_largest.csv` (the largest errors) and
`convergence.png` beside it. It takes about two minutes, nearly all of it in the adaptive
solver. The second command writes `convergence_learned.csv`, of trained laws of each architecture;
it takes about as long.

The cases are the vanilla controllers of the paper, sector and reflex, at ω 4 ... 8 rad/s and σ from
1 to 8 rad/(s N), released from 1.2 m, for 20 s. The error of a case is the largest over its hops.

How sensitive a case is, is measured by a release 1e-7 m higher, and by an oscillator faster by a
share of 1e-7: its amplification is by how much more than 1e-7 m an apex then moves. Regular cases
amplify by at most 30, and count; chaotic ones by more than 1000, and show nothing about
integrators; sensitive ones lie between, and are counted apart.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from math import cos, pi, prod, sin, sqrt
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import tegotae
from research.frame import main, write_rows
from tegotae.analysis.simulation import largest_change_m
from tegotae.figures.style import PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.hopping.hopping import hop_height_m
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import (
    ConstantGain,
    Network,
    Reflex,
    Sector,
    SectorAndReflex,
    VanillaAction,
    VanillaReaction,
)
from tegotae.simulation.integrators import (
    Hold,
    Integrator,
    Moment,
    PredictorCorrector,
    held,
    moved,
    phase_of,
)
from tegotae.systems.controller_file import load

FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parents[1] / "tests" / "helpers"))

from oracle import Law, fly, network, vanilla  # noqa: E402

OMEGAS = (4.0, 5.0, 6.0, 7.0, 8.0)
SIGMAS = (1.0, 2.753, 4.0, 6.0, 8.0)
TICKS_S = (0.0005, 0.001, 0.002, 0.004)
DURATION_S = 20.0
ACTUATIONS = {"sector": Sector(), "reflex": Reflex()}
DESIGNS = (
    *("VG-gF-both", "VT-tphif", "VGT-gF-tphif", "AR-rF-both", "ART-rF-tphif"),
    *("ARG-rF-gF-both", "ARGT-rF-gF-tphif"),
)
"""A design of each architecture, on the spring force, its actuation on phase and feedback."""
LEARNED_RUNS = (0, 1)
"""Runs of each design at 4 and 8 rad/s in the study's zoo."""
LEARNED_TICKS_S = (0.0005, 0.001, 0.002)
PERTURBATION = 1e-7
REGULAR = 30.0
CHAOTIC = 1000.0
"""Largest amplification of a regular case, and least of a chaotic one."""
ASKED_M = 1e-3
"""The accuracy that the project asks for."""
TOP_MM = 1000.0
"""The figure's upper edge."""


@dataclass(frozen=True)
class Heun(Integrator):
    """Heun's method in PECE form, as a textbook has it: two controller evaluations per tick."""

    def tick(self, setting, moment):
        """Advance by one tick; see `Integrator.tick`."""
        controller, body, *_, ground_m, tick_s = setting
        first = moment.drive
        phase = phase_of(controller, moment.oscillator, first.feedback)
        guess = held(moment.oscillator, first.rate, tick_s)
        phase_guess = phase_of(controller, guess, first.feedback)
        force = setting.push(first.command, phase, phase_guess)
        body_guess, _ = body.advance(moment.body, force, ground_m, tick_s)
        second = setting.drive(body_guess, guess)

        oscillator = moved(
            moment.oscillator, lambda a, b: 0.5 * tick_s * (a + b), first.rate, second.rate
        )
        phase_end = phase_of(controller, oscillator, first.feedback)
        mean_force = 0.5 * (first.command + second.command)
        force = setting.push(mean_force, phase, phase_end)
        state, contact = body.advance(moment.body, force, ground_m, tick_s)
        end = setting.drive(state, oscillator)
        return Moment(state, oscillator, end, first), contact, force


SCHEMES = {
    "hold": Hold(),
    "heun": Heun(),
    "predictor-corrector": PredictorCorrector(),
}
EVALUATIONS = {"hold": 1, "heun": 2, "predictor-corrector": 1}


@dataclass(frozen=True)
class Reference:
    """Solution of a case by the adaptive solver."""

    hops_m: np.ndarray
    """Heights of its hops [m]."""
    amplification: float
    """Factor by which a small change of release or frequency grows within the case."""


def reference(law: Law, omega: float) -> Reference:
    """Solve a case, and once more from a release a little higher."""
    flown = fly(law, omega=omega, duration=DURATION_S)
    amplification = 0.0
    for higher, faster in ((PERTURBATION, 0.0), (0.0, PERTURBATION)):
        neighbour = fly(law, omega=omega * (1.0 + faster), height=1.2 + higher, duration=DURATION_S)
        if len(flown.apex_height) != len(neighbour.apex_height):
            amplification = np.inf
            break
        moved = np.abs(flown.apex_height - neighbour.apex_height).max(initial=0.0)
        amplification = max(amplification, moved / PERTURBATION)
    hops = flown.apex_height >= hop_height_m(1.0)
    return Reference(flown.apex_height[hops], amplification)


def kind(amplification: float) -> str:
    """Return the kind of a case: regular, sensitive or chaotic."""
    if amplification <= REGULAR:
        return "regular"
    return "sensitive" if amplification <= CHAOTIC else "chaotic"


def apexes(actuation: str, integrator: Integrator, tick_s: float, dtype: str) -> np.ndarray:
    """Return the apex heights [m] of all cases, shape [frames, cases]; NaN in frames without an
    apex.
    """
    terms = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
    rollout = tegotae.Rollout(
        controller=Controller(ACTUATIONS[actuation], PhaseOscillator(), terms),
        integrator=integrator,
        timing=tegotae.Timing(duration_s=DURATION_S, tick_s=tick_s),
        summary=_only_apexes,
    )
    omega, sigma = np.array([(w, s) for w in OMEGAS for s in SIGMAS]).T
    return rollout.run(sigma[:, None], tegotae.Scenario(omega=omega), dtype=dtype)


def _only_apexes(trajectory, scenario, body, timing):
    return trajectory.apex_height_m


def study() -> list[dict]:
    """Return a row per actuation, scheme, number type, tick and case that is not chaotic."""
    cases = [(w, s) for w in OMEGAS for s in SIGMAS]
    runs = [(scheme, tick_s, "float64") for scheme in SCHEMES for tick_s in TICKS_S]
    runs += [("predictor-corrector", tick_s, "float32") for tick_s in TICKS_S]
    rows = []
    for actuation in ACTUATIONS:
        expected = []
        for i, case in enumerate(cases):
            omega, sigma = case
            expected.append(reference(vanilla(sigma, actuation), omega))
            print(f"\r{actuation}: adaptive solver {i + 1}/{len(cases)}", end="", flush=True)
        print()
        for scheme, tick_s, dtype in runs:
            heights = apexes(actuation, SCHEMES[scheme], tick_s, dtype)
            rows += [
                {
                    "actuation": actuation,
                    "scheme": scheme,
                    "evaluations_per_tick": EVALUATIONS[scheme],
                    "dtype": dtype,
                    "tick_ms": 1e3 * tick_s,
                    "omega_rad_per_s": omega,
                    "sigma_rad_per_s_n": sigma,
                    "amplification": solution.amplification,
                    "kind": kind(solution.amplification),
                    "hops": len(solution.hops_m),
                    "largest_apex_error_mm": 1e3
                    * largest_change_m(heights[:, i], solution.hops_m, 1.0),
                }
                for i, ((omega, sigma), solution) in enumerate(zip(cases, expected, strict=True))
                if kind(solution.amplification) != "chaotic"
            ]
    return rows


def learned(saved: tegotae.SavedController) -> Law:
    """Return a trained law in the solver's form, from the equations and the weights alone."""
    controller, body, weights = saved.controller, saved.body, np.asarray(saved.weights, float)
    terms = {
        role: (term, weights[controller.layout[role]]) for role, term in controller.terms.items()
    }
    force_n = body.mass_kg * body.gravity_m_per_s2
    speed = sqrt(body.gravity_m_per_s2 * body.rest_length_m)
    rate = sqrt(body.gravity_m_per_s2 / body.rest_length_m)

    def value(role: str, phase: float, spring: float, v: float, f: float = 0.0) -> float:
        term, numbers = terms[role]
        if isinstance(term, Network):
            read = {"sin_phase": sin(phase), "cos_phase": cos(phase), "feedback": f / rate}
            read |= {"spring_force": spring / force_n, "velocity": v / speed}
            return network(numbers, tuple(read[name] for name in term.reads))
        plain = {VanillaAction: -cos(phase), VanillaReaction: spring, ConstantGain: numbers}
        plain |= {Sector: 0.0, Reflex: -min(0.0, f), SectorAndReflex: -min(0.0, f)}
        return float(np.sum(plain[type(term)]))

    def feedback(phase: float, spring: float, v: float) -> float:
        factors = [role for role in terms if role != "actuation"]
        return prod(value(role, phase, spring, v) for role in factors) if factors else 0.0

    def force(phase: float, f: float, spring: float, v: float) -> float:
        return value("actuation", phase, spring, v, f)

    switches = isinstance(controller.actuation, Sector)
    sector = (1.75 * pi, 1.85 * pi) if switches else None
    return Law(f"{saved.name} {weights.tolist()}", feedback, force, sector)


def study_of_learned() -> list[dict]:
    """Return a row per trained law that is not chaotic, number type and tick."""
    runs = [(tick_s, "float64") for tick_s in LEARNED_TICKS_S] + [(0.001, "float32")]
    rows = []
    names = [f"{d}-w{w}/{run}" for d in DESIGNS for w in (4, 8) for run in LEARNED_RUNS]
    for name in names:
        saved = load(f"zoo:paper:{name}")
        assert saved.omega is not None
        solution = reference(learned(saved), saved.omega)
        print(f"{name}: {kind(solution.amplification)}", flush=True)
        for tick_s, dtype in runs:
            rollout = tegotae.Rollout(
                controller=saved.controller,
                timing=tegotae.Timing(duration_s=DURATION_S, tick_s=tick_s),
                summary=_only_apexes,
            )
            heights = rollout.run(saved.weights, tegotae.Scenario(omega=saved.omega), dtype=dtype)
            rows.append(
                {
                    "architecture": name.partition("-")[0],
                    "law": name,
                    "dtype": dtype,
                    "tick_ms": 1e3 * tick_s,
                    "amplification": solution.amplification,
                    "kind": kind(solution.amplification),
                    "hops": len(solution.hops_m),
                    "largest_apex_error_mm": 1e3
                    * largest_change_m(heights[:, 0], solution.hops_m, 1.0),
                }
            )
    return rows


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Return the largest error [mm] of every combination, a column per control period."""
    keys = ["kind", "scheme", "dtype", "actuation"]
    groups = table.groupby([*keys, "tick_ms"], sort=False).largest_apex_error_mm
    largest = groups.max().map(lambda x: "hops lost" if np.isinf(x) else f"{float(f'{x:.2g}'):g}")
    result = largest.unstack().rename(columns=lambda tick_ms: f"{tick_ms:g} ms")
    result.insert(0, "cases", groups.size().unstack()[1e3 * TICKS_S[0]])
    order = table[keys].drop_duplicates().sort_values("kind", kind="stable")
    return result.loc[list(order.itertuples(index=False, name=None))].reset_index()


STYLES = {
    ("hold", "float64"): ("held over the tick (1 evaluation)", "0.6", "s", ":"),
    ("heun", "float64"): ("Heun (2 evaluations)", "0.4", "^", "--"),
    ("predictor-corrector", "float64"): ("predictor-corrector (1 evaluation)", "0.0", "o", "-"),
    ("predictor-corrector", "float32"): ("the same in float32", "0.0", "x", "none"),
}
"""Label, grey, marker and line of each curve."""


def draw(table: pd.DataFrame) -> Figure:
    """Draw worst (marked) and median (thin) error over the control period, one panel per
    actuation.
    """
    regular = table[table.kind == "regular"]
    with styled():
        figure = new_figure(PAGE_IN, 3.1)
        axes = figure.subplots(1, 2, sharey=True)
        for axis, actuation in zip(axes, ACTUATIONS, strict=True):
            rows = regular[regular.actuation == actuation]
            _panel(axis, rows)
            cases = len(rows[["omega_rad_per_s", "sigma_rad_per_s_n"]].drop_duplicates())
            axis.set_title(f"{actuation} actuation, {cases} regular cases")
        axes[0].set_ylabel("apex error in 20 s [mm]\nmarked: worst case, thin: median")
        axes[0].annotate("1 mm asked", (0.5, 1.0), (0, 2), textcoords="offset points", color="0.5")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _panel(axis: Axes, rows: pd.DataFrame) -> None:
    for (scheme, dtype), (label, grey, marker, line) in STYLES.items():
        errors = rows[(rows.scheme == scheme) & (rows.dtype == dtype)].groupby("tick_ms")
        worst = errors.largest_apex_error_mm.max()
        axis.plot(worst, color=grey, marker=marker, ls=line, label=label)
        axis.plot(errors.largest_apex_error_mm.median(), color=grey, ls=line, lw=0.7)
        for tick_ms in worst.index[np.isinf(worst)]:
            axis.text(tick_ms, TOP_MM, "hops\nlost", color=grey, ha="center", va="top")
    axis.axhline(1e3 * ASKED_M, color="0.8", lw=0.8, zorder=0)
    axis.set(xscale="log", yscale="log", xlabel="control period [ms]", ylim=(5e-4, TOP_MM))
    axis.set_xticks(worst.index, [f"{tick_ms:g}" for tick_ms in worst.index])
    axis.minorticks_off()


def laws() -> None:
    """Run the study of learned laws, and write its table."""
    write_rows(FOLDER / "convergence_learned.csv", study_of_learned(), digits=4)


def vanilla_cases() -> None:
    """Run the study of vanilla feedback, and write its tables and figure."""
    table = pd.DataFrame(study())
    write_rows(FOLDER / "convergence.csv", table.to_dict("records"), digits=4)
    largest = FOLDER / "convergence_largest.csv"
    summary(table).to_csv(largest, index=False, lineterminator="\n")
    save_figure(draw(table), FOLDER / "convergence.png")


if __name__ == "__main__":
    main(laws, vanilla=vanilla_cases)
