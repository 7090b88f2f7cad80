"""The map of short laws: a million of them, drawn evenly, on hoppers and on a quadruped.

    python -m research.law_map.run                 # what is missing of it
    python -m research.law_map.run --laws 4096     # a coarse one
    python -m research.law_map.run --figure-only   # the figure anew, from the kept map

Every law is φ̇ = ω - a R(N) (cos(φ - p) + o), with N the load over what a leg carries in stance at
rest, weight / legs, and R one of three forms:

- `load`: N, Tegotae's own; a quarter of the laws;
- `latch`: (N - N*) / √(1 + N*²), which changes sign at the load N*; a half of them;
- `decay`: e^(-N / N₀), a quarter.

A hopper pushes over a sector of the phase around the place of vanilla's, of a drawn width; the
quadruped moves its own feet. Place p, offset o, rate a, and N* or N₀ are drawn by a scrambled
Sobol sequence, the phases of the release with them. The same laws meet every command, ω.

A law's merit is its CoT⁻¹, and 0 unless it hops on a limit cycle; on legs unless it walks: upright,
locked, and with half of the speed at which a foot crosses its stride in half a turn.

Blocks of laws are kept in a folder, and go on where another call ended. Written to
`research/law_map` are `map.npz`, of bins of place and shape; `summary.csv`; `laws.csv`, the
best laws of the map, judged by releases that did not choose them; `named.csv`, laws trained by PGPE
and Tegotae's own, likewise; `convergence.csv`; and the figure.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import tegotae as tg
from research.frame import main, write_rows
from research.law_map.figure import draw_all
from research.law_map.laws import (
    DECAYS,
    ENDS,
    FORMS,
    OFFSETS,
    PUSH,
    SEED,
    SUBJECTS,
    TITLES,
    TURN,
    VANILLA,
    WIDTHS,
    Laws,
    between,
    drawn,
    height_of,
    measured,
)
from tegotae._support.files import read_arrays, write_arrays
from tegotae.measures.evaluation import Protocol
from tegotae.measures.gaits.names import TOLERANCE
from tegotae.simulation.rollout import Timing
from tegotae.study import MOST_BYTES, Arrays, CellResult, Study, run_locally
from tegotae.systems.legged import random_phases
from tegotae.training.collection import read_runs

DOCS = Path(__file__).resolve().parents[2] / "docs"
BLOCK = 2**14
BINS = (48, 36)
"""Places and shapes of a map."""
RELEASES, CHOOSING, JUDGING = 8, 101, 202
"""Releases of a judgement, and the seeds of those that choose vanilla's gain and that judge."""
JUDGED_LONGER, LONGER = 2, (2, 4)
"""Factors by which episodes of a judgement are longer than those of the map, and those of the
check."""
LOCKED = 0.05
"""Largest deviation of a locked law's rate from ω, over ω."""
KEPT = 32
"""Best laws of each form at each command that are judged, and kept."""
TRAINED = {
    "study": [(law, w) for w in (4.0, 8.0) for law in ("load", "offset", "latch", "decay")],
    "quadruped": [(law, 2.0) for law in FORMS],
    "calibrated": [],
}
"""Laws that PGPE trains on each body, and at which ω."""


@dataclass(frozen=True)
class Block:
    """A block of laws at a command, as a cell of the study."""

    subject: str
    omega: float
    form: str
    first: int
    count: int

    @property
    def name(self) -> str:
        """Return the name of the block."""
        return f"{self.subject}-{self.form}-w{self.omega:g}-{self.first}"

    @property
    def program(self) -> tuple[str, str]:
        """Blocks of one body and form are one compiled program."""
        return self.subject, self.form

    @property
    def document(self) -> dict[str, Any]:
        """Return the document of the options that determine the cell's numbers."""
        settings = SUBJECTS[self.subject]
        ranges = [list(x) for x in (OFFSETS, WIDTHS, DECAYS, settings.rates)]
        timing = dataclasses.asdict(settings.timing)
        return {**dataclasses.asdict(self), "seed": SEED, "ranges": ranges, "timing": timing}

    def prepare(self) -> None:
        """Prepare nothing: a block needs no other cell."""

    def measure(self) -> CellResult:
        """Measure the laws of the cell."""
        laws, phases = drawn(self.subject, self.form, self.first, self.count)
        timing = SUBJECTS[self.subject].timing
        results = measured(self.subject, self.form, laws, phases, self.omega, timing)
        return CellResult(self.document, {}, results)


def blocks(subject: str, form: str, laws: int) -> list[Block]:
    """Return the blocks of a form on a body, all commands of the first laws first."""
    count = round(FORMS[form] * SUBJECTS[subject].share * laws)
    size = min(BLOCK, count)
    return [
        Block(subject, omega, form, first, min(size, count - first))
        for first in range(0, count, size)
        for omega in SUBJECTS[subject].omegas
    ]


@dataclass(frozen=True)
class Outcomes:
    """Results of the laws of one form on a body, [laws] each."""

    laws: Laws
    by_command: dict[float, Arrays]
    """Results of `measured`, by ω."""


def outcomes(folder: Path, subject: str, form: str, laws: int) -> Outcomes:
    """Measure what the folder lacks of a form's blocks, and read all of them."""
    study = Study(folder / "records", blocks(subject, form, laws), "law map", "blocks")
    study.run(run_locally)
    parts: dict[float, list[Arrays]] = {}
    for result in study.results():
        parts.setdefault(result.document["omega"], []).append(result.arrays)
    joined = {
        omega: {name: np.concatenate([block[name] for block in arrays]) for name in arrays[0]}
        for omega, arrays in parts.items()
    }
    count = len(next(iter(joined.values()))["merit"])
    return Outcomes(drawn(subject, form, 0, count)[0], joined)


def longer(timing: Timing, times: int) -> Timing:
    """Return a timing whose episodes are so many times as long."""
    return dataclasses.replace(timing, duration_s=times * timing.duration_s)


def binned(form: str, laws: Laws, merit: np.ndarray, lock: np.ndarray) -> Arrays:
    """Return a map of laws, [places, shapes] each: the merit that one law in twenty of a bin
    surpasses, the share of laws that move, and the median of their rate over ω.
    """
    places, shapes = BINS
    column = np.clip((laws.place / TURN + 0.5) * places, 0, places - 1).astype(int)
    row = np.clip(height_of(form, laws.shape) * shapes, 0, shapes - 1).astype(int)
    number = column * shapes + row

    def of_bins(values: np.ndarray, share: float, among: np.ndarray) -> np.ndarray:
        order = np.lexsort((values[among], number[among]))
        edges = np.searchsorted(number[among][order], np.arange(places * shapes + 1))
        count = np.diff(edges)
        result = np.full(len(count), np.nan)
        index = (edges[:-1] + share * count).astype(int)[count > 0]
        result[count > 0] = values[among][order][index]
        return result.reshape(BINS)

    moves = merit > 0.0
    count = np.bincount(number, minlength=places * shapes)
    moving = np.bincount(number, moves, places * shapes)
    return {
        "merit": of_bins(merit, 0.95, np.ones_like(moves)),
        "moves": (moving / np.maximum(count, 1)).reshape(BINS),
        "lock": of_bins(lock, 0.5, moves),
    }


def released(subject: str, form: str, laws: Laws, omega: float, seed: int = JUDGING) -> Arrays:
    """Apply `measured` to laws released from random phases, [laws, releases] each."""
    system, count = SUBJECTS[subject], len(laws.place)
    phases = np.tile(random_phases(system.legs, RELEASES, seed), count)
    repeated = Laws(*(np.repeat(x, RELEASES) for x in laws))
    timing = longer(system.timing, JUDGED_LONGER)
    lanes = measured(subject, form, repeated, phases, omega, timing)
    return {name: values.reshape(count, RELEASES) for name, values in lanes.items()}


def judged(subject: str, form: str, laws: Laws, *, seed: int = JUDGING) -> Arrays:
    """Return the mean merit over random releases, share of those that move, and median rate
    over ω, of the lower and the higher command; and the slope of the rate over ω, 1 if it
    follows.
    """
    system, results, rates = SUBJECTS[subject], {}, []
    for end, omega in zip(ENDS, system.omegas, strict=True):
        lanes = released(subject, form, laws, omega, seed)
        rates.append(medians(lanes["rate"]))
        results[f"merit_{end}"] = lanes["merit"].mean(axis=1)
        results[f"moves_{end}"] = (lanes["merit"] > 0.0).mean(axis=1)
        results[f"lock_{end}"] = rates[-1] / omega
        if system.legs > 1:
            results[f"speed_{end}"] = medians(lanes["speed"])
    return results | {"following": (rates[1] - rates[0]) / (system.omegas[1] - system.omegas[0])}


def around(subject: str, form: str, laws: Laws, omega: float) -> np.ndarray:
    """Return the mean merit over releases and the five commands of the evaluation of a hopper,
    [laws]; NaN on legs.
    """
    if SUBJECTS[subject].legs > 1:
        return np.full(len(laws.place), np.nan)
    commands = [omega + offset for offset in Protocol().offsets]
    return np.mean([released(subject, form, laws, w)["merit"].mean(axis=1) for w in commands], 0)


def medians(values: np.ndarray) -> np.ndarray:
    """Return the median of every row's defined values; NaN where there is none."""
    return np.ma.median(np.ma.masked_invalid(values), axis=1).filled(np.nan)


def rows_of(laws: Laws, results: Arrays, **labels: Any) -> list[dict[str, Any]]:
    """Return one row per law."""
    columns = dict(zip(TITLES, laws, strict=True)) | results
    count = len(laws.place)
    columns = {name: np.broadcast_to(x, count) for name, x in (labels | columns).items()}
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def taken(laws: Laws, indices: np.ndarray) -> Laws:
    """Return some of the laws."""
    return Laws(*(x[indices] for x in laws))


def vanilla(subject: str) -> tuple[Laws, Arrays]:
    """Return Tegotae's cosine, with the rate a that is best at either command, and its evaluation.

    The rates are chosen by releases of their own.
    """
    rates = between(SUBJECTS[subject].rates, np.linspace(0.0, 1.0, 64), log=True)
    zero = np.zeros_like(rates)
    laws = Laws(zero, zero, rates, zero, zero + VANILLA.width_rad)
    selection = judged(subject, "load", laws, seed=CHOOSING)
    best = taken(laws, np.array([selection[f"merit_{end}"].argmax() for end in ENDS]))
    return best, judged(subject, "load", best)


def trained(subject: str, law: str, omega: float, folder: Path, seeds: int) -> tuple[str, Laws]:
    """Return a named law as PGPE trained it, in the terms of the map, and its form."""
    name = f"{law}@quadruped-c" if subject == "quadruped" else f"{law}-w{omega:g}"
    tg.train(name, seeds=seeds, out=folder / name)
    (runs,) = read_runs(folder / name)
    layout, weights = runs.system.controller.layout, np.asarray(runs.weights, float)
    action, reaction, gain, sector = (
        weights[:, layout[part]].T for part in ("action", "reaction", "gain", "actuation")
    )
    zero, legs = np.zeros(len(weights)), SUBJECTS[subject].legs
    place, offset = action if len(action) == 2 else (zero, action[0] if len(action) else zero)
    start, width = sector if len(sector) else (zero + PUSH, zero)
    width = np.clip(width, 0.0, TURN)
    form, rate = ("load" if law == "offset" else law), gain[0]
    if form == "load":
        body = runs.system.mechanics
        rate = rate * body.mass_kg * body.gravity_m_per_s2 / legs
    if form == "latch":
        shape = legs / reaction[0]
        rate = -np.copysign(rate * np.hypot(1.0, 1.0 / shape), rate * reaction[0])
    elif form == "decay":
        shape = legs / np.maximum(reaction[0], 1e-6)
    # A law of the other sign is one half a turn away.
    offset, place = np.where(rate < 0.0, (-offset, place + np.pi), (offset, place))
    place = (place + PUSH - start - 0.5 * width + np.pi) % TURN - np.pi
    return form, Laws(place, offset if form == "load" else shape, np.abs(rate), offset, width)


@dataclass(frozen=True)
class LawMap:
    """Measure and draw the map of short laws."""

    laws: int = 2**20
    """Laws of the study's body, a power of two; a quarter of them meets each other one."""
    subjects: tuple[str, ...] = ("study", "calibrated", "quadruped")
    """Bodies: study, quadruped, calibrated."""
    sample: int = 2**11
    """Laws that are judged to compare with, and measured for longer."""
    seeds: int = 15
    """Runs of each law of the hopper that PGPE trains; 0 trains none."""
    dir: Path = Path("results/law_map")
    """Folder of the blocks."""
    trainings: Path = Path("results/short_laws")
    """Folder of the trainings, that of `short_laws.py`."""
    out: Path = DOCS.parent / "research" / "law_map"
    """Folder of tables and figure."""
    figure_only: bool = False
    """Draw the kept tables anew."""

    def run(self) -> None:
        """Measure, judge, write and draw."""
        if not self.figure_only:
            maps: Arrays = {}
            for subject in self.subjects:
                tables = self._subject_rows(subject, maps)
                for name, rows in tables.items():
                    write_rows(self.out / f"{name}.csv", rows, digits=4, by=("subject",))
            write_arrays(self.out / "map.npz", self._other_maps() | maps)
        draw_all(self.out)

    def _other_maps(self) -> Arrays:
        """Return the kept maps of other bodies."""
        file = self.out / "map.npz"
        if not file.exists():
            return {}
        maps = read_arrays(file, MOST_BYTES)
        return {name: x for name, x in maps.items() if name.split()[0] not in self.subjects}

    def _subject_rows(self, subject: str, maps: Arrays) -> dict[str, list[dict[str, Any]]]:
        tables: dict[str, list[dict[str, Any]]] = {"summary": [], "laws": [], "convergence": []}
        sample: dict[str, Arrays] = {}
        for form, share in FORMS.items():
            all_laws = outcomes(self.dir, subject, form, self.laws)
            few = taken(all_laws.laws, np.arange(round(share * self.sample)))
            sample[form] = judged(subject, form, few)
            for end, (omega, results) in zip(ENDS, all_laws.by_command.items(), strict=True):
                labels = {"subject": subject, "omega": omega, "form": form}
                lock = results["rate"] / omega
                map_of_form = binned(form, all_laws.laws, results["merit"], lock)
                for name, values in map_of_form.items():
                    maps[f"{subject} {omega:g} {form} {name}"] = values.astype("float16")
                ranked = np.argsort(-results["merit"], kind="stable")
                best = taken(all_laws.laws, ranked[:KEPT])
                found_again = judged(subject, form, best)
                of_map = {
                    "merit_of_map": results["merit"][ranked[:KEPT]],
                    "merit_around": around(subject, form, best, omega),
                }
                tables["laws"] += rows_of(best, of_map | found_again, **labels)
                top = ranked[: max(1, len(ranked) // 200)]
                tables["summary"].append(
                    labels | described(all_laws, results, lock, top, found_again[f"merit_{end}"])
                )
                tables["convergence"].append(
                    labels
                    | self._convergence(subject, form, omega, all_laws.laws, results, map_of_form)
                )
        return tables | {"named": self._reference_laws(subject, sample)}

    def _convergence(
        self, subject: str, form: str, omega: float, laws: Laws, results: Arrays, full: Arrays
    ) -> dict[str, float]:
        """Compare the map with that of the first half of the laws, and with longer episodes of some
        laws."""
        merit, half = results["merit"], np.arange(len(results["merit"]) // 2)
        first = binned(form, taken(laws, half), merit[half], results["rate"][half] / omega)
        some = np.arange(min(self.sample, len(merit)))
        again, phases = drawn(subject, form, 0, len(some))
        short, timing = merit[some], SUBJECTS[subject].timing
        long = {}
        for times in LONGER:
            longer_timing = longer(timing, times)
            long_merit = measured(subject, form, again, phases, omega, longer_timing)["merit"]
            moving = (short > 0.0) & (long_merit > 0.0)
            long |= {
                f"moves_{times}": (long_merit > 0.0).mean(),
                f"same_{times}": ((short > 0.0) == (long_merit > 0.0)).mean(),
                f"merit_correlation_{times}": correlation(short[moving], long_merit[moving]),
            }
        return {
            "moves": (merit > 0.0).mean(),
            "moves_half": (merit[half] > 0.0).mean(),
            "map_difference": np.nanmean(np.abs(first["merit"] - full["merit"])),
            "map_spread": np.nanstd(full["merit"]),
            "map_correlation": correlation(first["merit"], full["merit"]),
            "laws_longer": len(some),
            "moves_1": (short > 0.0).mean(),
            **long,
        }

    def _reference_laws(self, subject: str, sample: dict[str, Arrays]) -> list[dict[str, Any]]:
        """Return Tegotae's law, with its rank in the evaluated sample, and the trained ones."""
        laws, results = vanilla(subject)
        below, below_moving = [], []
        for k, end in enumerate(ENDS):
            merits = np.concatenate([arrays[f"merit_{end}"] for arrays in sample.values()])
            less = merits < results[f"merit_{end}"][k]
            below.append(less.mean())
            below_moving.append(less[merits > 0.0].mean() if merits.any() else np.nan)
        omegas = SUBJECTS[subject].omegas
        ranks = {
            "merit": [results[f"merit_{end}"][k] for k, end in enumerate(ENDS)],
            "merit_around": [around(subject, "load", laws, w)[k] for k, w in enumerate(omegas)],
            "below": below,
            "below_moving": below_moving,
        }
        label = {"subject": subject, "law": "vanilla", "form": "load", "run": 0}
        rows = rows_of(laws, results | ranks, **label, omega=np.array(omegas))
        for law, omega in TRAINED[subject] if self.seeds else ():
            seeds = min(self.seeds, 5) if subject == "quadruped" else self.seeds
            form, trained_laws = trained(subject, law, omega, self.trainings, seeds)
            label = {"subject": subject, "law": law, "form": form, "run": np.arange(seeds)}
            results = judged(subject, form, trained_laws)
            end = ENDS[SUBJECTS[subject].omegas.index(omega)]
            results["merit"] = results[f"merit_{end}"]
            results["merit_around"] = around(subject, form, trained_laws, omega)
            rows += rows_of(trained_laws, results, **label, omega=omega)
        return rows


def described(
    all_laws: Outcomes, results: Arrays, lock: np.ndarray, top: np.ndarray, judged_merit: np.ndarray
) -> dict[str, float]:
    """Return a line on the laws of a form at a command, and on the place of the best of them,
    `top`.
    """
    merit, laws = results["merit"], all_laws.laws
    moves, locked = merit > 0.0, np.abs(lock - 1.0) < LOCKED
    omegas, rates = zip(
        *((omega, x["rate"]) for omega, x in all_laws.by_command.items()), strict=True
    )
    follows = (rates[1] - rates[0]) / (omegas[1] - omegas[0])
    direction = np.exp(1j * laws.place[top]).mean()
    low, middle, high = np.quantile(laws.shape[top], (0.25, 0.5, 0.75))
    return {
        "laws": len(merit),
        "moves": moves.mean(),
        "fails": results["failed"].mean(),
        "locked": locked.sum() / max(1, moves.sum()),
        "merit_median": quantile(merit[moves], 0.5),
        "merit_99": quantile(merit[moves], 0.99),
        "merit_99_locked": quantile(merit[locked], 0.99),
        "merit_best_judged": judged_merit.max(),
        "top_place_rad": np.angle(direction),
        "top_place_agreement": abs(direction),
        "top_shape_low": low,
        "top_shape": middle,
        "top_shape_high": high,
        "top_offset": np.median(laws.offset[top]),
        "top_rate_rad_per_s": np.median(laws.rate[top]),
        "top_lock": quantile(lock[top], 0.5),
        "moves_at_both": np.isfinite(follows).mean(),
        "following": quantile(follows, 0.5),
        "top_following": quantile(follows[top], 0.5),
        "trots": trots(results)[moves].mean() if moves.any() else math.nan,
        "top_trots": trots(results)[top].mean(),
    }


def trots(results: Arrays) -> np.ndarray:
    """Return True where diagonal legs step together and the others half a stride later; NaN on one
    leg."""
    if "lag_LF" not in results:
        return np.full(len(results["merit"]), np.nan)
    lags = {"lag_LF": 0.5, "lag_RF": 0.0, "lag_RH": 0.5}
    off = [np.abs((results[name] - lag + 0.5) % 1.0 - 0.5) for name, lag in lags.items()]
    return np.asarray(np.max(off, axis=0) <= TOLERANCE, float)


def quantile(values: np.ndarray, share: float) -> float:
    """Return a quantile of the defined values, or NaN if there are none."""
    finite = values[np.isfinite(values)]
    return float(np.quantile(finite, share)) if len(finite) else math.nan


def correlation(x: np.ndarray, y: np.ndarray) -> float:
    """Return Pearson's correlation where both values are defined, or NaN for fewer than two."""
    finite = np.isfinite(x) & np.isfinite(y)
    varied = finite.sum() > 1 and np.ptp(x[finite]) > 0.0 and np.ptp(y[finite]) > 0.0
    return float(np.corrcoef(x[finite], y[finite])[0, 1]) if varied else math.nan


if __name__ == "__main__":
    main(LawMap)
