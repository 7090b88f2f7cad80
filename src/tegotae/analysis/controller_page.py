"""The page about a controller: its score without its feedback, its curves, its short forms, and the
sentences about them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from tegotae.analysis.explanation import (
    ALIKE,
    EPISODE,
    NOTHING,
    Arc,
    Evaluated,
    ReleasedController,
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
from tegotae.analysis.surface import sees_velocity
from tegotae.measures.statistics import UNDEFINED, Interval, mean_defined
from tegotae.parts.bodies import Hopper, Walker
from tegotae.parts.fields import unwrapped
from tegotae.parts.maths import TWO_PI

_MUCH = 0.5
"""Share of the score below which most of it is gone."""
_FOLLOWS, _WEAKLY = 0.75, 0.25
"""Smallest slopes of the rate over ω of a controller that follows, and that follows weakly."""
_BENT = 0.15
"""Distance from a line, over the mean, of rates that jump."""
_ALL = 0.99
"""Share of the stance that is nearly all of it."""
_OFF = 0.05
"""Distance from one hop in a turn of the phase of several hops, or of a part of one."""


@dataclass(frozen=True)
class ControllerPage:
    """Numbers on a controller, and the text about them.

    Args:
        name: name of the controller.
        released: releases from which it was evaluated.
        visited: states of its gait at the frequency of its training, set of weights by set.
        evaluated: its scores, whole and without its feedback.
        feedback_rad_per_s: its mean feedback over the gait, [frequencies].
        forms: short forms, as they were tried; none where there is nothing to keep.
    """

    name: str
    released: ReleasedController
    visited: Sequence[Visits]
    evaluated: Mapping[str, Evaluated]
    feedback_rad_per_s: np.ndarray
    forms: Sequence[TriedForm]

    @classmethod
    def from_releases(
        cls, released: ReleasedController, *, name: str, retune: int, seeds: Sequence[int]
    ) -> ControllerPage:
        """Return the page about a controller, evaluated from releases.

        Args:
            released: its releases.
            name: name of the controller.
            retune: generations for which each short form is retuned; 0 tries none.
            seeds: seeds of the retuning.
        """
        saved = released.saved
        whole = released.evaluated(saved.controller, saved.weights)
        recorded = released.recorded()
        feedback, visited = mean_feedback(whole, recorded), visits(released, whole, recorded)
        is_readable = saved.body.limbs == 1 or (
            saved.controller.tegotae is not None and saved.experiment is not None
        )
        halves = [whole.of_releases(half).mean.mean for half in (CHOOSING, JUDGING)]
        forms: list[TriedForm] = []
        if retune and is_readable and saved.omega and min(halves) >= NOTHING:
            forms = tried_forms(released, whole, visited, generations=retune, seeds=seeds)
        evaluated = {"whole": whole, **without_feedback(released, feedback)}
        return cls(name, released, visited, evaluated, feedback, forms)

    @property
    def hops(self) -> bool:
        """True on one leg."""
        return self.released.saved.body.limbs == 1

    @property
    def table(self) -> pd.DataFrame:
        """Scores, one row per variant, release and frequency."""
        axes = (range(self.released.shape[0]), self.released.omega)
        episodes = pd.MultiIndex.from_product(axes, names=["release", "omega_rad_per_s"])
        variants = {
            name: pd.DataFrame({y: np.ravel(getattr(x, y)) for y in EPISODE}, episodes)
            for name, x in self.evaluated.items()
        }
        return pd.concat(variants, names=["variant"]).reset_index()

    @cached_property
    def scores(self) -> pd.DataFrame:
        """The score of the whole controller and without its feedback."""
        unit, sound = ("m/J", "settles") if self.hops else ("1", "stays up")
        rows = []
        for name, x in self.evaluated.items():
            row = {
                "": name,
                f"mean CoT⁻¹ [{unit}]": _ranged(x.mean),
                sound: f"{x.sound.mean():.0%}",
                "following": _short(x.following_of_releases.mean),
                f"rate [rad/s] at ω = {' '.join(map(_short, x.omega))}": " ".join(
                    map(_short, x.rates)
                ),
            }
            if not self.hops:
                row["speed [m/s]"] = " ".join(map(_short, mean_defined(x.speed_m_per_s.T)))
            rows.append(row)
        return pd.DataFrame(rows).set_index("")

    @cached_property
    def curves(self) -> pd.DataFrame:
        """The feedback's curves as formulas, with the share of the variance over the visits."""
        rows = []
        for i, v in enumerate(self.visited):
            fits = []
            if np.isfinite(v.action).all():
                actions = {x.formula: x for x in action_fits(v)}  # one harmonic may be all
                fits += [("A′(φ)", x) for x in actions.values()]
            if np.isfinite(v.gain * v.reaction).all():
                fits += [("G R(N)", x) for x in reaction_fits(v).values()]
            rows += [(i, curve, x.formula, _explained(x.explained)) for curve, x in fits]
        table = pd.DataFrame(rows, columns=["set", "curve", "formula", "R²"])
        indexed = table.set_index(["set", "curve"])
        return indexed if len(self.visited) > 1 else indexed.droplevel("set")

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
                "settles" if self.hops else "stays up": f"{form.evaluated.sound.mean():.0%}",
                "following": _short(form.evaluated.following_of_releases.mean),
            }
            for form in self.forms
        ]
        return pd.DataFrame(rows, columns=None if rows else ["form"]).set_index("form")

    @cached_property
    def chosen(self) -> dict[float, TriedForm | None]:
        """The shortest form that keeps each share of the score; None where no form does."""
        return {share: shortest(self.forms, share) for share in SHARES}

    @property
    def chosen_forms(self) -> list[TriedForm]:
        """The forms of `chosen`, each once."""
        return list(dict.fromkeys(filter(None, self.chosen.values())))

    def sentences(self) -> list[str]:
        """Return the text of the page."""
        paragraphs = (
            self._score_section,
            self._feedback_section,
            self._command_section,
            self._visits_section,
            self._reading_section,
            self._forms_section,
        )
        return [note for paragraph in paragraphs for note in paragraph()]

    def _score_section(self) -> list[str]:
        """Return the score, and the share of episodes with a gait."""
        intact, unit = self.evaluated["whole"], " m/J" if self.hops else ""
        kind, opposite = ("settle", "does not settle") if self.hops else ("stay up", "falls")
        frequencies = [_short(x) for x in intact.omega if np.isfinite(x)]
        commands = f" at ω = {_listed(frequencies)} rad/s" if frequencies else ""
        return [
            f"The score, mean CoT⁻¹, is {intact.mean.mean:.3g}{unit} over {len(intact.merit)} "
            f"releases{commands}. Of the episodes {intact.sound.mean():.0%} {kind}; what "
            f"{opposite} counts as 0."
        ]

    def _feedback_section(self) -> list[str]:
        """Return the effect of cutting and freezing the feedback on the score."""
        intact = self.evaluated["whole"]
        if self.released.saved.controller.tegotae is None:
            moved = "force" if self.hops else "feet"
            return [f"There is no feedback that could be cut: one network commands the {moved}."]
        if intact.mean.mean < NOTHING:
            return ["From these releases it does not get anywhere."]
        cut, frozen = (self.evaluated[name] for name in ("cut", "frozen"))
        sentence = f"Cutting the feedback changes the score by {_ranged(cut.over(intact))}"
        held_at = f"and holding it at its mean by {_ranged(frozen.over(intact))}"
        kind = "a clock with a sector" if self.hops else "a clock"
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

    def _command_section(self) -> list[str]:
        """Return the response of the rate to ω."""
        intact = self.evaluated["whole"]
        slopes, cycles = intact.following_of_releases, "hops" if self.hops else "steps"
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
            f"{_listed(map(_short, omega))} (mean slope of the releases {_ranged(slopes)})."
        ]
        turning = float(np.mean([v.rate_rad_per_s.mean() for v in self.visited]))
        hops = intact.rates[self.released.middle] / turning if turning > 0.0 else math.nan
        if self.hops and abs(hops - 1.0) > _OFF:
            middle = intact.omega[self.released.middle]
            sentences.append(
                f"At ω = {middle:.3g} it hops {hops:.2g} times in a turn of its phase."
            )
        return sentences

    def _visits_section(self) -> list[str]:
        """Return the phases at which the controller waits, stands and pushes."""
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

    def _reading_section(self) -> list[str]:
        """Return the senses of reaction and gain beside the load, over which they are drawn."""
        terms = self.released.saved.controller.terms
        read = [
            name for role in ("reaction", "gain") if role in terms for name in terms[role].reads
        ]
        senses = (name.removeprefix("sin_").removeprefix("cos_") for name in read)
        names = [name.replace("_", " ") for name in dict.fromkeys(senses) if name != "spring_force"]
        sentence = f"G R reads the {_listed(names)}, too: no formula of N alone is that curve."
        return [sentence] if names else []

    def _forms_section(self) -> list[str]:
        """Return the shortest forms that keep shares of the score."""
        if not self.forms:
            return []
        sentences: list[str] = []
        for form in self.chosen_forms:
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

    def markdown(self) -> str:
        """Return the page in Markdown; its figures are beside it."""
        parts = [f"# {self.name}", *self.sentences(), "## Scores", _markdown(self.scores)]
        parts += ["![curves](curves.png)", self._caption]
        if len(self.curves):
            parts += ["## Curves", _markdown(self.curves)]
        if self.forms:
            parts += ["## Short forms", _markdown(self.tried), "![forms](forms.png)"]
        for form in self.chosen_forms:
            code = f"```c\n{c_line(form.saved)}\n```", f"```python\n{python(form.saved)}\n```"
            parts += [f"### {form.name}", f"$$\n{latex(form.saved)}\n$$", *code]
        return "\n\n".join(parts) + "\n"

    @property
    def _caption(self) -> str:
        """Caption of the figure, with the meaning of the letters on the page."""
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
            f"{'hops' if self.hops else 'steps'} over the command ω.{unit}*"
        )


def _short(x: float) -> str:
    return UNDEFINED if math.isnan(x) else f"{x:.3g}"


def _explained(share: float) -> str:
    """Return R² for people: below zero it is worse than a constant."""
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
    """Return intervals of phases in words."""
    rows = [
        f"{x.start_rad:.2f} ... {(x.start_rad + x.width_rad) % TWO_PI:.2f}"
        for x in places
        if x.share >= 0.05
    ]
    if any(x.width_rad == TWO_PI for x in places):
        return "at every phase"
    return f"at φ = {_listed(rows)} rad" if rows else "at no phase of its own"


def _listed(words: Iterable[str]) -> str:
    """Return words with commas, and one "and"."""
    *first, last = list(words) or [""]
    return f"{', '.join(first)} and {last}" if first else last


def _markdown(table: pd.DataFrame) -> str:
    """Return a table in Markdown."""
    cells = table.reset_index().astype(str)
    rows = [list(cells.columns), ["---"] * len(cells.columns), *cells.to_numpy().tolist()]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
