"""Explanation of one controller on a page: its gait, and its score without its feedback."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

import tegotae
from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.files import write_atomically
from tegotae._support.limits import MOST_POINTS
from tegotae.analysis.explanation import (
    ALIKE,
    NOTHING,
    SPREAD_M,
    Arc,
    Evaluated,
    ReleasedController,
    ReleasedHopper,
    ReleasedWalker,
    Visits,
    action_fits,
    arcs,
    mean_feedback,
    parking,
    pushing,
    reaction_fits,
    visits,
    without_feedback,
)
from tegotae.analysis.short_forms import (
    CHOOSING,
    JUDGING,
    SHARES,
    TriedForm,
    c_line,
    latex,
    plain_law,
    python,
    shortest,
    tried_forms,
)
from tegotae.analysis.surface import actuation_surface, sees_velocity
from tegotae.api.controller import LoadedController
from tegotae.api.hopping import HopperController
from tegotae.api.results import UNDEFINED, Table
from tegotae.api.walking import WalkerController
from tegotae.measures.statistics import Interval, mean_defined
from tegotae.parts.bodies import Hopper, Walker
from tegotae.parts.fields import unwrapped
from tegotae.parts.maths import TWO_PI
from tegotae.simulation.world import OMEGA
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.legged import random_phases
from tegotae.systems.resolve import resolve

if TYPE_CHECKING:
    from matplotlib import figure

    from tegotae.analysis.surface import Surface

_MUCH = 0.5
"""A share of the score below which most of it is gone."""
_FOLLOWS, _WEAKLY = 0.75, 0.25
"""Slopes of the rate over ω, from which on a controller follows, or follows weakly."""
_BENT = 0.15
"""So far off a line, over their mean, are rates that jump."""
_ALL = 0.99
"""A share of the stance that is nearly all of it."""
_OFF = 0.05
"""So far from one hop in a turn of the phase are several hops, or a part of one."""


def explain(controller: LoadedController, options: Any) -> Explanation:
    """Explain a controller on one page (`LoadedController.explain`).

    Args:
        controller: the controller.
        options: parameters of the method, without None.

    Raises:
        TegotaeError: for a controller elsewhere than on a body of this package, or values that
            cannot be.
    """
    task = _explainable(controller)
    require_finite("duration_s", options.duration_s, least=1.0)
    require_count("releases", options.releases, most=MOST_POINTS)
    require_count("seed", options.seed, least=0)
    require_count("retune", options.retune, least=0)
    require_count("retune_seeds", options.retune_seeds, most=MOST_POINTS)
    require_count("first_seed", options.first_seed, least=0)
    if options.retune and options.releases < 2:
        raise TegotaeError(
            "releases is 1; it must be at least 2, of which one half chooses among the short forms "
            "and the other judges; or retune none, with retune 0"
        )
    released = _released(task, options)
    evaluated_controller = released.evaluated(released.saved.controller, released.saved.weights)
    recorded = released.recorded()
    feedback = mean_feedback(evaluated_controller, recorded)
    visited = visits(released, evaluated_controller, recorded)
    seeds = range(options.first_seed, options.first_seed + options.retune_seeds)
    forms: list[TriedForm] = []
    has_reading = released.saved.controller.tegotae is not None or released.saved.body.limbs == 1
    has_reading &= released.saved.experiment is not None or released.saved.body.limbs == 1
    halves = [evaluated_controller.of_releases(half).mean.mean for half in (CHOOSING, JUDGING)]
    if options.retune and has_reading and released.saved.omega and min(halves) >= NOTHING:
        forms = tried_forms(
            released, evaluated_controller, visited, generations=options.retune, seeds=seeds
        )
    explanation = Explanation(
        title=task.name,
        name=task.name,
        released=released,
        visited=visited,
        evaluated={"whole": evaluated_controller, **without_feedback(released, feedback)},
        feedback_rad_per_s=feedback,
        forms=forms,
        settings=vars(options),
    )
    return replace(explanation, notes=explanation.sentences())


def _explainable(controller: LoadedController) -> HopperController | WalkerController:
    """The controller, which must be one on a body of this package."""
    if len(controller.runs.weights) > 1 and controller.source:
        resolve(controller.source).controller()  # refused, with the file of one
    if isinstance(controller, WalkerController):
        if not isinstance(unwrapped(controller.runs.body), Walker):
            raise TegotaeError(
                f"explain judges legs by their cost of transport, and {controller.name} hops in "
                "place; tegotae gait sweep and tegotae gait stability study it"
            )
        return controller
    return controller.require(
        HopperController,
        "explain reads what moves on a body of this package; tegotae simulate and tegotae "
        "evaluate run it there",
    )


def _released(task: HopperController | WalkerController, options: Any) -> ReleasedController:
    """The releases from which a controller is evaluated."""
    runs, n = task.runs, options.releases
    saved = SavedController(runs.system, task.weights, task.name, runs.experiment)
    if isinstance(task, WalkerController):
        legged = task.legged
        timing = replace(legged.timing, duration_s=options.duration_s)
        release = legged.scenario(random_phases(legged.body.limbs, n, options.seed))
        return ReleasedWalker(saved, _frequencies(saved), release, timing, legged=legged)
    protocol = replace(runs.protocol, undisturbed_s=options.duration_s)
    draw, usual_m = np.random.default_rng(options.seed), runs.system.release.height_m
    release = runs.system.scenario(
        height_m=usual_m + draw.uniform(-SPREAD_M, SPREAD_M, n),
        phase_rad=draw.uniform(0.0, TWO_PI, n),
    )
    timing = runs.system.timing_over(options.duration_s, tick_s=protocol.tick_s)
    return ReleasedHopper(saved, _frequencies(saved, protocol.offsets), release, timing, protocol)


def _frequencies(saved: SavedController, offsets: Sequence[float] = ()) -> np.ndarray:
    """The commands [rad/s]: those of the evaluation, those of the training, or around its own."""
    omega = saved.omega
    if omega is None:
        return np.array([math.nan])
    conditions = () if saved.experiment is None else saved.experiment.conditions
    for condition in conditions:
        if condition.name == OMEGA:
            return np.linspace(min(condition.extremes), max(condition.extremes), 5)
    around = omega + np.array(offsets)
    return around if len(around) and min(around) > 0.0 else omega * np.linspace(0.5, 1.5, 5)


@dataclass(frozen=True, repr=False, kw_only=True)
class Explanation(Table):
    """Explanation of a controller; its page is `page.md` of the folder that `save` writes."""

    name: str
    """Of the controller."""
    released: ReleasedController
    """From which releases it was evaluated."""
    visited: Sequence[Visits]
    """What its gait visits at the frequency of its training, set of weights by set."""
    evaluated: Mapping[str, Evaluated]
    """How good it is: whole, and without its feedback."""
    feedback_rad_per_s: np.ndarray
    """Its mean over the gait, [frequencies]."""
    forms: Sequence[TriedForm]
    """Short forms, as they were tried; none where there is nothing to keep."""
    settings: Mapping[str, Any]
    """Options of the explanation."""

    @property
    def _hops(self) -> bool:
        return self.released.saved.body.limbs == 1

    @property
    def _has_feedback(self) -> bool:
        return self.released.saved.controller.tegotae is not None

    @property
    def table(self) -> pd.DataFrame:
        """Scores, a row a variant, release and frequency."""
        releases, n = self.released.shape
        rows = [
            pd.DataFrame(
                {
                    "variant": name,
                    "release": np.repeat(np.arange(releases), n),
                    "omega_rad_per_s": np.tile(x.omega, releases),
                    "merit": x.merit.ravel(),
                    "rate_rad_per_s": x.rate_rad_per_s.ravel(),
                    "sound": x.sound.ravel(),
                    "speed_m_per_s": x.speed_m_per_s.ravel(),
                }
            )
            for name, x in self.evaluated.items()
        ]
        return pd.concat(rows, ignore_index=True)

    @cached_property
    def scores(self) -> pd.DataFrame:
        """The score of the whole controller and without its feedback."""
        unit, sound = ("m/J", "settles") if self._hops else ("1", "stays up")
        rows = []
        for name, x in self.evaluated.items():
            row = {
                "": name,
                f"mean CoT⁻¹ [{unit}]": _ranged(x.mean),
                sound: f"{x.sound.mean():.0%}",
                "following": _short(x.following),
                f"rate [rad/s] at ω = {' '.join(map(_short, x.omega))}": " ".join(
                    map(_short, x.rates)
                ),
            }
            if not self._hops:
                row["speed [m/s]"] = " ".join(map(_short, mean_defined(x.speed_m_per_s.T)))
            rows.append(row)
        return pd.DataFrame(rows).set_index("")

    @cached_property
    def curves(self) -> pd.DataFrame:
        """The feedback's curves as formulas, with the share of the variance over the visits."""
        rows = []
        for i, v in enumerate(self.visited):
            curves = {"A′(φ)": v.action, "G R(N)": v.gain * v.reaction}
            is_finite = {name: np.isfinite(x).all() for name, x in curves.items()}
            actions = {x.formula: x for x in action_fits(v)}.values()  # one harmonic may be all
            fits = [("A′(φ)", x) for x in actions] if is_finite["A′(φ)"] else []
            fits += (
                [("G R(N)", x) for x in reaction_fits(v).values()] if is_finite["G R(N)"] else []
            )
            for curve, fit in fits:
                row = {"curve": curve, "formula": fit.formula, "R²": _explained(fit.explained)}
                rows.append({"set": i, **row})
        table = pd.DataFrame(rows, columns=["set", "curve", "formula", "R²"])
        several = len(self.visited) > 1
        return table.set_index(["set", "curve"] if several else "curve").drop(
            columns=[] if several else "set"
        )

    @cached_property
    def tried(self) -> pd.DataFrame:
        """Short forms, with the numbers of the curves and retuned."""
        rows = [
            {
                "form": form.name,
                "numbers": form.numbers,
                "cloned": _short(form.cloned.mean.mean),
                "retuned": _ranged(form.evaluated.mean),
                "chosen by": f"{form.chosen_by:.0%}",
                "keeps": f"{form.kept:.0%}",
                "settles" if self._hops else "stays up": f"{form.evaluated.sound.mean():.0%}",
                "following": _short(form.evaluated.following),
            }
            for form in self.forms
        ]
        return pd.DataFrame(rows, columns=None if rows else ["form"]).set_index("form")

    @cached_property
    def chosen(self) -> dict[float, TriedForm | None]:
        """The shortest form that keeps each share of the score; None where no form does."""
        return {share: shortest(self.forms, share) for share in SHARES}

    def texts(self) -> list[pd.DataFrame]:
        return [table for table in (self.scores, self.curves, self.tried) if len(table)]

    def sentences(self) -> list[str]:
        """Return the text of the page."""
        paragraphs = (
            self._of_score,
            self._of_feedback,
            self._of_command,
            self._of_visits,
            self._of_reading,
            self._of_forms,
        )
        return [note for paragraph in paragraphs for note in paragraph()]

    def _of_score(self) -> list[str]:
        """What the score is, and how much of it are episodes without a gait."""
        intact, unit = self.evaluated["whole"], " m/J" if self._hops else ""
        kind, opposite = ("settle", "does not settle") if self._hops else ("stay up", "falls")
        frequencies = [_short(x) for x in intact.omega if np.isfinite(x)]
        commands = f" at ω = {_listed(frequencies)} rad/s" if frequencies else ""
        return [
            f"The score, mean CoT⁻¹, is {intact.mean.mean:.3g}{unit} over {len(intact.merit)} "
            f"releases{commands}. Of the episodes {intact.sound.mean():.0%} {kind}; what "
            f"{opposite} counts as 0."
        ]

    def _of_feedback(self) -> list[str]:
        """What cutting and freezing the feedback does to the score."""
        intact = self.evaluated["whole"]
        if not self._has_feedback:
            moved = "force" if self._hops else "feet"
            return [f"There is no feedback that could be cut: one network commands the {moved}."]
        if intact.mean.mean < NOTHING:
            return ["From these releases it does not get anywhere."]
        cut, frozen = (self.evaluated[name] for name in ("cut", "frozen"))
        sentence = f"Cutting the feedback changes the score by {_ranged(cut.over(intact))}"
        held_at = f"and holding it at its mean by {_ranged(frozen.over(intact))}"
        kind = "a clock with a sector" if self._hops else "a clock"
        unknown = "too small to tell from these releases"
        if cut.over(intact, 1.0 / ALIKE).low > 0.0:
            return [f"{sentence}: from these releases its feedback costs more than it gains."]
        if cut.over(intact, ALIKE).low >= 0.0:
            return [f"{sentence}: this controller is {kind}."]
        if not cut.over(intact, ALIKE).high < 0.0:
            return [f"{sentence}: what its feedback is worth is {unknown}."]
        if frozen.over(intact, ALIKE).low >= 0.0:
            return [f"{sentence}, {held_at}: it is {kind} of another frequency."]
        if not frozen.over(intact, ALIKE).high < 0.0:
            return [
                f"{sentence}, {held_at}: what its changes within a cycle are worth is {unknown}."
            ]
        is_necessary = all(x.over(intact, _MUCH).high < 0.0 for x in (cut, frozen))
        much = "most" if is_necessary else "part"
        changes = f"changes of the feedback within a cycle make {much} of the score"
        actuation = self.released.saved.controller.actuation
        if {*actuation.reads} == {"feedback"} and not actuation.needs_phase:
            moved = "force follows" if actuation.commands_force else "feet follow"
            changes += f". The {moved} the feedback alone, and so cannot do without it"
        return [f"{sentence}, {held_at}: {changes}."]

    def _of_command(self) -> list[str]:
        """Whether the rate follows ω."""
        intact = self.evaluated["whole"]
        slopes, cycles = intact.following_of_releases, "hops" if self._hops else "steps"
        if np.isnan(intact.omega).all():
            return ["It has no oscillator, and so no command to follow."]
        if math.isnan(slopes.mean):
            return ["It settles at fewer than two frequencies: whether it follows is unknown."]
        likely = (slopes.low, slopes.mean, slopes.high)
        words = [_follows(slope) for slope in likely if not math.isnan(slope)]
        verdict = " or ".join(dict.fromkeys(words))
        is_finite = np.isfinite(intact.rates)
        omega, rates = intact.omega[is_finite], intact.rates[is_finite]
        line = np.polyval(np.polyfit(omega, rates, 1), omega)
        bent = np.abs(rates - line).max() > _BENT * rates.mean()
        kind = "Its rate is no line over its command" if bent else f"It {verdict} its command"
        sentences = [
            f"{kind}: it {cycles} at {_listed(map(_short, rates))} rad/s where ω is "
            f"{_listed(map(_short, omega))} (slope {_ranged(slopes)})."
        ]
        turning = float(np.mean([v.rate_rad_per_s.mean() for v in self.visited]))
        hops = intact.rates[self.released.middle] / turning if turning > 0.0 else math.nan
        if self._hops and abs(hops - 1.0) > _OFF:
            middle = intact.omega[self.released.middle]
            sentences.append(
                f"At ω = {middle:.3g} it hops {hops:.2g} times in a turn of its phase."
            )
        return sentences

    def _of_visits(self) -> list[str]:
        """Where the phase waits, stands and pushes."""
        saved, sentences = self.released.saved, []
        if saved.omega is None:
            return []
        omega = float(self.released.omega[self.released.middle])
        for i, v in enumerate(self.visited):
            owner = "" if len(self.visited) == 1 else f" of the set {i}"
            waits = [
                f"{share:.0%} of the time in {where}, {_places(places)}"
                for where, (share, places) in parking(v, omega).items()
                if places and share >= 0.01
            ]
            stands = arcs(v.phase_rad, np.ones_like(v.stance), v.stance)
            sentences.append(
                f"The phase{owner} waits {' and '.join(waits) or 'nowhere'}; the leg stands "
                f"{v.stance.mean():.0%} of the time, {_places(stands)}."
            )
            if saved.controller.actuation.commands_force:
                share, places = pushing(v, float(np.max(saved.body.max_force_n)))
                when = f"for {share:.0%} of the stance, {_places(places)}"
                when = "throughout the stance" if share > _ALL else when
                sentences.append(f"It pushes, with more than half of its largest force, {when}.")
        if not self.evaluated["whole"].sound[:, self.released.middle].any():
            sentences.append("No release settles there: the curves are those of unsettled gaits.")
        return sentences

    def _of_reading(self) -> list[str]:
        """What the reaction and the gain read beside the load, over which they are drawn."""
        terms = self.released.saved.controller.terms
        read = [
            name for role in ("reaction", "gain") if role in terms for name in terms[role].reads
        ]
        senses = (name.removeprefix("sin_").removeprefix("cos_") for name in read)
        names = [name.replace("_", " ") for name in dict.fromkeys(senses) if name != "spring_force"]
        sentence = f"G R reads the {_listed(names)}, too: no formula of N alone is that curve."
        return [sentence] if names else []

    def _of_forms(self) -> list[str]:
        """The shortest forms that keep shares of the score."""
        if not self.forms:
            return []
        sentences: list[str] = []
        for form in dict.fromkeys(filter(None, self.chosen.values())):
            shares = [f"{share:.0%}" for share, x in self.chosen.items() if x is form]
            feet = f" beside the {form.of_feet} of its feet" if form.of_feet else ""
            sentences.append(
                f"The shortest form that keeps {_listed(shares)} of the score is {form.name}, "
                f"{form.numbers} numbers{feet}; from the releases that did not choose it, it keeps "
                f"{form.kept:.0%}: {plain_law(form.saved)}."
            )
        if none := [f"{share:.0%}" for share, form in self.chosen.items() if form is None]:
            sentences.append(f"None of the library keeps {' or '.join(none)}.")
        if max(form.kept for form in self.forms) > 1.0 / ALIKE:
            sentences.append(
                "A form may score above the controller: it is retuned from many releases, and "
                "its rate over ω may be another."
            )
        return sentences

    def to_dict(self) -> JsonObject:
        scores = {
            name: {"mean": x.mean, "following": x.following, **asdict(x)}
            for name, x in self.evaluated.items()
        }
        curves = self.curves.reset_index().to_dict("records")
        settings = {"name": self.name, "settings": self.settings}
        forms = [
            {
                "name": form.name,
                "chosen_by": form.chosen_by,
                "kept": form.kept,
                "weights": form.saved.weights,
            }
            for form in self.forms
        ]
        results = {"scores": scores, "curves": curves, "forms": forms, "said": self.notes}
        return as_json({**settings, "feedback_rad_per_s": self.feedback_rad_per_s, **results})

    def figures(self) -> Mapping[str, figure.Figure]:
        from tegotae.figures.explanation import explanation_figure, forms_figure

        surface = self._surface()
        drawn = explanation_figure(self.name, self.visited, surface, self.evaluated)
        rows = [(form.name, form.numbers, form.evaluated.mean) for form in self.forms]
        unit = "m/J" if self._hops else "1"
        further = {"forms": forms_figure(rows, self.evaluated, unit)} if rows else {}
        return {"curves": drawn, **further}

    def _surface(self) -> Surface | None:
        saved, v = self.released.saved, self.visited[0]
        if not isinstance(saved.body, Hopper):
            return None
        most_n = 1.1 * max(float(v.spring_force_n.max()), float(saved.body.weight_n))
        most_n = min(most_n, saved.body.most_spring_n)
        return actuation_surface(saved, np.linspace(0.0, most_n, 80), columns=120)

    def page(self) -> str:
        """The page, in Markdown; its figures are beside it."""
        parts = [f"# {self.name}", *self.notes, "## Scores", _markdown(self.scores)]
        parts += ["![curves](curves.png)", self._caption]
        if len(self.curves):
            parts += ["## Curves", _markdown(self.curves)]
        if self.forms:
            parts += ["## Short forms", _markdown(self.tried), "![forms](forms.png)"]
        for form in dict.fromkeys(filter(None, self.chosen.values())):
            code = f"```c\n{c_line(form.saved)}\n```", f"```python\n{python(form.saved)}\n```"
            parts += [f"### {form.name}", f"$$\n{latex(form.saved)}\n$$", *code]
        return "\n\n".join(parts) + "\n"

    @property
    def _caption(self) -> str:
        """What the figure shows, and what the letters of the page mean."""
        body, below = self.released.saved.body, "the force over phase and spring force"
        if not isinstance(body, Hopper):
            below = "the rate of the phase"
        elif sees_velocity(self.released.saved):
            below += ", for a velocity of 0"
        unit, mechanics = "", unwrapped(body)
        if (
            isinstance(mechanics, Walker)
            and mechanics.gravity_m_per_s2 == mechanics.rest_length_m == 1.0
        ):
            unit = " Mass, leg and gravity are 1 here: 1 m/s is √(g l0)."
        return (
            "*Dots are moments of settled gaits at the frequency of the training. Above: the "
            "action A′ over the phase φ, behind it the share of the time in each 60th of a turn; "
            "the reaction with its gain, G R, over the load N, the spring force in weights of the "
            f"body. The feedback is f = G R A′. Below: {below}; the rate of "
            f"{'hops' if self._hops else 'steps'} over the command ω.{unit}*"
        )

    def _fill(self, folder: Path) -> list[Path]:
        """Write the page, its figures, numbers and document into a folder, and the shortest forms,
        each as a controller file and as a folder of C."""
        paths = super()._fill(folder)
        for form in dict.fromkeys(filter(None, self.chosen.values())):
            paths.append(folder / f"{form.name}.json")
            save(form.saved, paths[-1])
            if self._hops:
                paths += tegotae.robots.export_c(form.saved).save(folder / f"{form.name}-c")
        path = folder / "page.md"
        write_atomically(path, self.page())
        return [path, *paths]


def _short(x: float) -> str:
    return UNDEFINED if math.isnan(x) else f"{x:.3g}"


def _explained(share: float) -> str:
    """R² as people read it: below zero it is worse than a constant."""
    if math.isnan(share):
        return "constant"
    return f"{share:.2f}" if share >= 0.0 else "< 0"


def _follows(slope: float) -> str:
    """Return the word for a slope of the rate over ω."""
    if slope < _FOLLOWS:
        return "ignores" if slope < _WEAKLY else "weakly follows"
    return "overdoes" if slope > 1.0 / _FOLLOWS else "follows"


def _ranged(mean: Interval) -> str:
    ends = "" if math.isnan(mean.low) else f" [{mean.low:.3g}, {mean.high:.3g}]"
    return f"{_short(mean.mean)}{ends}"


def _places(places: Sequence[Arc]) -> str:
    """Intervals of phases in words."""
    rows = [
        f"{x.start_rad:.2f} ... {(x.start_rad + x.width_rad) % TWO_PI:.2f}"
        for x in places
        if x.share >= 0.05
    ]
    if any(x.width_rad == TWO_PI for x in places):
        return "at every phase"
    return f"at φ = {_listed(rows)} rad" if rows else "at no phase of its own"


def _listed(words: Iterable[str]) -> str:
    """Words with commas, and one "and"."""
    *first, last = list(words) or [""]
    return f"{', '.join(first)} and {last}" if first else last


def _markdown(table: pd.DataFrame) -> str:
    """A table in Markdown."""
    cells = table.reset_index().astype(str)
    rows = [list(cells.columns), ["---"] * len(cells.columns), *cells.to_numpy().tolist()]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
