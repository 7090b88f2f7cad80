"""Feet that react to the loss of any leg: a law by hand, how far its gains reach, learned laws.

    python -m research.lost_leg.react search     # gains and networks; a few CPU-minutes
    python -m research.lost_leg.react zoo        # all of them, for names of the zoo
    python -m research.lost_leg.react report     # table and picture

Searches are kept in `runs/lost_leg` and go on where they were interrupted; tables and figures are
in `research/lost_leg`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from research.frame import main, markdown_table, write_rows, write_text
from research.legs_limit import strategies
from research.lost_leg.film import draw_frames, loses
from research.lost_leg.laws import UNSEEN, Law, loss_of, scores
from research.lost_leg.run import FOLDER, TABLES, leg_loss_rows, rounded
from research.reproduction.zoo import ZooEntry, write_archive
from tegotae._support.engines import NATIVE
from tegotae._support.files import output_folder
from tegotae.figures.style import save_figure, styled
from tegotae.parts.bodies import Walker
from tegotae.parts.terms import EllipticFoot
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController, load
from tegotae.systems.legged import Legged, settling
from tegotae.systems.vanilla import walking
from tegotae.training.learner import versions_of

ZOO = Path(__file__).resolve().parents[2] / "src/tegotae/systems/zoo/data/lost-leg.npz"
"""Archive of the learned laws, for names such as `zoo:lost-leg:feels-tilt@quadruped-c`."""
STEADY = EllipticFoot(stride_m=0.22, lift_m=0.04, press_m=0.0, shift_rad=0.26)
"""Small quick steps that bear a reaction, and its ω and σ below: of a pilot that searched for gait
and gains at once."""
OMEGA, SIGMA = 10.2, 3.2
PHASES = 4
"""Random releases of each leg's loss in a generation; all candidates of it have the same ones."""
ONE_SIDE = (0, 2)
"""Legs that are lost in a search, LF and LH: the laws are alike or mirror images on both sides."""


@dataclass(frozen=True)
class Plan:
    """A law and how it is searched for.

    Args:
        law: its form.
        gains: of a law by hand its gains and their sizes; none of a network.
        generations: how many.
        population: candidates of each.
        std: first deviation.
        starts: how many searches, from other random numbers.
    """

    law: Law
    gains: tuple[tuple[str, float], ...] = ()
    generations: int = 200
    population: int = 32
    std: float = 0.3
    starts: int = 3

    def gains_of(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """Return the hand-tuned gains of a law by name, [lanes] each."""
        return {name: x[:, index] * size for index, (name, size) in enumerate(self.gains)}

    def weights(self, x: np.ndarray) -> np.ndarray:
        """Return the weights of the controller [lanes, n_weights] of vectors of the search
        [lanes, size].
        """
        return self.law.weights(self.law.by_hand(self.gains_of(x)) if self.gains else x, SIGMA)

    def begin(self) -> np.ndarray:
        """Return vectors to start from, [starts, size]: no gains and any gains, or networks
        that hardly react.
        """
        rng = np.random.default_rng(0)
        if self.gains:
            x = rng.normal(size=(self.starts, len(self.gains)))
            x[0] = 0.0
            return x
        return np.array([self.law.random(rng) for _ in range(self.starts)])

    def search(self, folder: Path) -> None:
        """Search, or continue a search."""
        legged = self.law.legged(steady(), self.weights(self.begin()[:1])[0])

        def losses(x: np.ndarray, generation: int) -> np.ndarray:
            values, _ = scores(
                legged, self.weights(x), missing=ONE_SIDE, starts=PHASES, seed=UNSEEN + generation
            )
            return loss_of(values)

        def report(generation: int, loss: np.ndarray) -> None:
            if generation % 20 == 0:
                print(f"{self.law.name} {generation}/{self.generations}:", *np.round(loss, 2),
                      flush=True)  # fmt: skip

        strategies.search(
            losses,
            self.begin(),
            std=self.std,
            population=self.population,
            generations=self.generations,
            seed=0,
            checkpoint=folder / f"{self.law.name}.npz",
            progress=report,
        )


SHIFT = (("shift_pitch", 4.0), ("shift_pitch_rate", 1.0))
LIFT = (("lift_roll", 1.0), ("lift_roll_rate", 0.3), ("lift_pitch", 0.5), ("lift_pitch_rate", 0.2))
_PITCH, _TILT = ("pitch", "pitch_rate"), ("pitch", "pitch_rate", "roll", "roll_rate")
_LOAD = "spring_force"
_WIDE = {"std": 0.7, "generations": 80, "population": 20, "starts": 6}
PLANS = (
    Plan(Law("shift-by-hand", "feet shifted by the pitch", STEADY, _PITCH, 1), SHIFT, **_WIDE),
    Plan(Law("lift-by-hand", "feet lifted by the tilt", STEADY, _TILT, 1, "place"), LIFT, **_WIDE),
    Plan(
        Law("tilt-by-hand", "feet shifted and lifted by the tilt", STEADY, _TILT, 1, "place"),
        SHIFT + LIFT,
        **_WIDE,
    ),
    Plan(
        Law("feels-tilt", "feet that feel load and tilt", STEADY, (_LOAD, *_TILT), 3, "place"),
        generations=300,
    ),
)
"""Laws by hand, whose gains are searched for; and learned ones."""


def steady() -> Legged:
    """Return quadruped C with these steps, and no reaction."""
    return walking("quadruped C, steady", Walker(), STEADY, SIGMA, OMEGA)


@dataclass(frozen=True)
class Search:
    """Search for gains and networks, and evaluate them on releases that no search has seen."""

    only: tuple[str, ...] = ()
    """Names of laws; all by default."""
    dir: Path = FOLDER

    def run(self) -> None:
        """Search what is missing, and write the table."""
        output_folder(self.dir)
        if not self.only:
            alone = leg_loss_rows("no reaction", steady(), {"0": steady().weights})
            alone = [{**row, "selection": 0.0} for row in alone]
            write_rows(TABLES / "reacting.csv", alone, digits=4, by=("body",))
        for plan in PLANS:
            name = plan.law.name
            if self.only and name not in self.only:
                continue
            plan.search(self.dir)
            result = strategies.load(self.dir / f"{name}.npz")
            weights = plan.weights(result.centre)
            legged = plan.law.legged(steady(), weights[0])
            selection, _ = scores(
                legged, weights, missing=ONE_SIDE, starts=32, seed=UNSEEN - 1
            )  # of the selection alone
            rows = leg_loss_rows(
                name, legged, {str(k): row_weights for k, row_weights in enumerate(weights)}
            )
            for row in rows:
                row["selection"] = -loss_of(selection)[int(row["run"])]
            write_rows(TABLES / "reacting.csv", rows, digits=4, by=("body",))
            gains = plan.gains_of(result.centre)
            write_rows(
                TABLES / "gains.csv",
                [
                    {"law": name, "run": run, "gain": gain, "value": value}
                    for gain, values in gains.items()
                    for run, value in enumerate(values)
                ],
                digits=4,
                by=("law",),
            )


@dataclass(frozen=True)
class Report:
    """The table in Markdown, and the picture."""

    law: str = "feels-tilt"
    """The law that is shown."""

    def run(self) -> None:
        """Write the table and the picture."""
        table = pd.read_csv(TABLES / "reacting.csv")
        write_text(TABLES / "reacting.md", markdown(table))
        saved = load(f"zoo:lost-leg:{self.law}@quadruped-c")
        law = settling(saved.system, saved.weights)
        legs, runs = ("LH", "LF"), {"no reaction": steady(), "feels tilt": law}
        episodes = {
            name: {leg: loses(controller, leg) for leg in legs} for name, controller in runs.items()
        }
        with styled():
            save_figure(draw_frames(episodes), TABLES / "frames.png")


def markdown(table: pd.DataFrame) -> str:
    """Return one row per law and leg, of the run that the selection prefers."""
    titles = ("law", "leg lost", "feet ahead before, after", "margin of feet before, after",
              "walks on", "other runs", "speed before, after", "CoT before, after")  # fmt: skip
    lines = [titles]
    pairs = (("feet", "feet_after"), ("margin_of_feet", "margin_after"),
             ("speed_before", "speed"), ("cost_before", "cost_of_transport"))  # fmt: skip
    for name, group in table.groupby("body", sort=False):
        best = group.run[group.selection.idxmax()]
        for _, row in group[group.run == best].iterrows():
            others = group.walks_on[(group.leg == row.leg) & (group.run != best)]
            feet, margin, speed, cost = (f"{rounded(row[a])}, {rounded(row[b])}" for a, b in pairs)
            walks, of_others = f"{row.walks_on} of {row.stood}", ", ".join(map(str, others))
            lines.append((name, row.leg, feet, margin, walks, of_others, speed, cost))
    return markdown_table(lines)


@dataclass(frozen=True)
class Zoo:
    """The package's file of the learned laws and those by hand."""

    dir: Path = FOLDER

    def run(self) -> None:
        """Write the archive of the laws whose search is finished."""
        output_folder(ZOO.parent)
        plans = [plan for plan in PLANS if (self.dir / f"{plan.law.name}.npz").exists()]
        write_archive(ZOO, "lost-leg", [entry(plan, self.dir) for plan in plans])


def entry(plan: Plan, folder: Path) -> ZooEntry:
    """Return all runs of a law, and their evaluation."""
    result = strategies.load(folder / f"{plan.law.name}.npz")
    weights = plan.weights(result.centre)
    system = plan.law.legged(steady(), weights[0]).system
    training = {
        "method": "research/lost_leg/react.py",
        "population": plan.population,
        "std": plan.std,
        "lost": "each leg by itself, in every episode",
    }
    name = f"{plan.law.name}@quadruped-c"
    saved = SavedController(
        system,
        weights[0],
        name,
        training=training,
        software={**versions_of("evosax"), "engine": NATIVE},
    )
    document = controller_file.described(saved, name)
    table = pd.read_csv(TABLES / "reacting.csv")
    table = table[table.body == plan.law.name]
    share = table.assign(share=table.walks_on / table.stood.clip(lower=1))
    metrics = {"selection": table.groupby("run").selection.first().to_numpy()}
    for leg, rows in share.groupby("leg", sort=False):
        metrics[f"walks_on_without_{leg}"] = rows.set_index("run").share.sort_index().to_numpy()
    return ZooEntry(
        document={name: value for name, value in document.items() if name != "weights"},
        weights=weights,
        seed=np.arange(len(weights)),
        fitness=-result.typical[-1],
        generations=np.full(len(weights), len(result.typical)),
        ended=np.full(len(weights), "cap"),
        metrics=metrics,
    )


if __name__ == "__main__":
    main(Search, Zoo, Report)
