"""The shortest formula that does what a controller does: a fixed library of forms, started from the
controller's curves, retuned in closed loop, and evaluated from releases that no training saw."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tegotae._support.limits import MOST_WEIGHTS
from tegotae._support.progress import reporting
from tegotae.analysis.explanation import (
    SPREAD_M,
    Evaluated,
    ReleasedController,
    Visits,
    action_fits,
    pushing,
    reaction_fits,
    signed,
)
from tegotae.measures.objectives.fitness import EPISODE
from tegotae.parts.controller import Controller
from tegotae.parts.fields import replace
from tegotae.parts.maths import TWO_PI
from tegotae.parts.terms import (
    DecayingReaction,
    FreeSector,
    FreeSectorAndReflex,
    OffsetAction,
    ReversingReaction,
    SaturatingReaction,
    ShiftedAction,
    Term,
    TwoHarmonicsAction,
    VanillaAction,
    VanillaReaction,
)
from tegotae.simulation.world import Uniform
from tegotae.systems.controller_file import SavedController
from tegotae.systems.experiment import Experiment
from tegotae.systems.term_sets import LAWS, ShortLaw
from tegotae.systems.vanilla import PRESETS
from tegotae.training.algorithms import PGPE
from tegotae.training.evolution import Evolution, Stopping

SHARES = (0.8, 0.95, 0.99)
"""Shares of the controller's score that a form is to keep."""
CHOOSING, JUDGING = slice(0, None, 2), slice(1, None, 2)
"""Releases that choose the shortest form, and those that judge it."""
_RETUNING = PGPE(population=64, std=0.3, std_lr=0.1, learning_rate=0.2, max_speed=0.4)
_REACTIONS: dict[str, Term] = {
    "offset": VanillaReaction(),
    "latch": ReversingReaction(),
    "decay": DecayingReaction(),
    "saturating": SaturatingReaction(),
}


def forms_of_a_leg() -> dict[str, ShortLaw]:
    """Return the library of one leg by name: short laws, with a second harmonic, and with a
    reflex.
    """
    forms = [LAWS["clock"], LAWS["load"], LAWS["tuned"]]
    for name, reaction in _REACTIONS.items():
        for suffix, action in (("", OffsetAction()), ("+harmonic", TwoHarmonicsAction())):
            for reflex, push in (("", FreeSector()), ("+reflex", FreeSectorAndReflex())):
                law = {"action": action, "reaction": reaction, "actuation": push}
                forms.append(ShortLaw(name=f"{name}{suffix}{reflex}", **law))
    return {form.name: form for form in forms}


def forms_of_legs() -> dict[str, ShortLaw]:
    """Return the library of several legs by name: their action has a place, and their feet stay."""
    return {
        name: ShortLaw(name=name, action=ShiftedAction(), reaction=reaction)
        for name, reaction in _REACTIONS.items()
    }


@dataclass(frozen=True, eq=False)
class TriedForm:
    """The result of one tested form.

    Args:
        name: of the library.
        saved: it, with its numbers.
        cloned: how good it was with the numbers of the fitted curves.
        evaluated: how good it is with those that it was retuned to.
        chosen_by: its score as a share of the controller's, over the releases that choose.
        kept: the same over the releases that judge.
    """

    name: str
    saved: SavedController
    cloned: Evaluated
    evaluated: Evaluated
    chosen_by: float
    kept: float

    @property
    def numbers(self) -> int:
        """Number of its parameters; for several legs, that of the feedback."""
        return len(self.saved.weights) - self.of_feet

    @property
    def of_feet(self) -> int:
        """Number of additional parameters of the feet of several legs, and of their coupling."""
        controller = self.saved.controller
        return (
            controller.n_weights - controller.sets * controller.layout["actuation"].start
            if controller.limbs > 1
            else 0
        )


def tried_forms(
    released: ReleasedController,
    baseline: Evaluated,
    visited: Sequence[Visits],
    *,
    generations: int,
    seeds: Sequence[int],
) -> list[TriedForm]:
    """Test forms, those of fewest numbers first, until one keeps all shares of the score.

    Of the seeds of a form the one of highest fitness in its training is taken; the score knows none
    of that training's releases.

    Args:
        released: the controller, and the releases of the evaluation.
        baseline: its score, which must be above 0 over either half of the releases.
        visited: its curves.
        generations: of the retuning.
        seeds: of the retuning.
    """
    candidates = [(name, *form) for name, form in starting_forms(released.saved, visited).items()]
    tried: list[TriedForm] = []
    with reporting("forms", len(candidates)) as reporter:
        for name, controller, start in sorted(candidates, key=lambda form: form[1].n_weights):
            best = max((form.chosen_by for form in tried), default=0.0)
            if tried and best >= SHARES[-1] and controller.n_weights > len(tried[-1].saved.weights):
                break
            experiment = training_of(released.saved, controller)
            runs, fitness = retuned(experiment, start, generations, seeds)
            weights = runs[fitness.argmax()]
            cloned = released.evaluated(controller, start)
            evaluated = released.evaluated(controller, weights)
            system = dataclasses.replace(released.saved.system, controller=controller)
            saved = SavedController(system, weights, name)
            shares = (
                evaluated.of_releases(half).mean.mean / baseline.of_releases(half).mean.mean
                for half in (CHOOSING, JUDGING)
            )
            tried.append(TriedForm(name, saved, cloned, evaluated, *shares))
            reporter.update(len(tried), f"{name} {tried[-1].kept:.0%}")
    return tried


def shortest(tried: Sequence[TriedForm], share: float) -> TriedForm | None:
    """Return the form of fewest numbers that keeps a share of the score, the best of several, or
    None.

    The releases that choose decide; `TriedForm.kept` then says what it keeps from the others.
    """
    enough = [form for form in tried if form.chosen_by >= share]
    return min(enough, key=lambda form: (form.numbers, -form.chosen_by), default=None)


def retuned(
    experiment: Experiment, starts: np.ndarray, generations: int, seeds: Sequence[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers that PGPE finds from given ones, and their training fitness.

    A formula has few numbers, of any size: the steps are larger than those of a network's weights.

    Args:
        experiment: the training.
        starts: numbers to start from, shape [n_weights], or [runs, n_weights].
        generations: how many.
        seeds: of the algorithm's draws, run by run.

    Returns:
        Numbers, [runs, n_weights], and fitness, [runs].
    """
    evolution = Evolution(algorithm=_RETUNING, stopping=Stopping.after(generations))
    begun = evolution.start(experiment, seeds)
    rows = np.array(np.broadcast_to(starts, begun.best_weights.shape), "float32")
    begun = begun._replace(search=begun.search.replace(mean=rows), best_weights=rows)
    *_, (ended, _) = evolution.evolve(experiment, seeds, begun)
    return np.asarray(ended.best_weights, float), np.asarray(ended.best_fitness, float)


def training_of(saved: SavedController, controller: Controller) -> Experiment:
    """Return the controller's own training of a form, from drawn releases."""
    experiment = saved.experiment
    if experiment is None:
        system = dataclasses.replace(saved.system, timing=EPISODE)
        experiment = Experiment(name="form", system=system)
    height_m = experiment.system.release.height_m
    drawn = [Uniform("phase_rad", low=0.0, high=TWO_PI)]
    if controller.limbs == 1:
        drawn += [Uniform("height_m", low=height_m - SPREAD_M, high=height_m + SPREAD_M)]
    names = {condition.name for condition in experiment.conditions}
    conditions = (*experiment.conditions, *(x for x in drawn if x.name not in names))
    return replace(experiment, {"name": "form", "controller": controller, "conditions": conditions})


def starting_forms(
    saved: SavedController, visited: Sequence[Visits]
) -> dict[str, tuple[Controller, np.ndarray]]:
    """Return the library's controllers by name, with the numbers of the fitted curves.

    Args:
        saved: the controller.
        visited: its curves, set of weights by set.
    """
    original, forms, system = saved.controller, forms_of_legs(), saved.system
    if original.limbs == 1:
        forms, system = forms_of_a_leg(), PRESETS["paper"].system("sector")
    results = {}
    for name, form in forms.items():
        controller = form.controller(system, MOST_WEIGHTS)
        units = [_numbers(controller, v) for v in visited[: controller.sets]]
        if original.limbs > 1:  # their feet and what couples them stay as they are
            n, first = original.unit_weights, original.layout["actuation"].start
            feet = [saved.weights[i * n + first : (i + 1) * n] for i in range(original.sets)]
            units = [np.concatenate(pair) for pair in zip(units, feet, strict=True)]
            units.append(saved.weights[original.sets * n :])
        results[name] = controller, np.concatenate(units)
    return results


def _numbers(controller: Controller, v: Visits) -> np.ndarray:
    """Return the numbers of a unit's form: its action, reaction and gain, and for one leg its push.

    Where its sector is free, phases are counted from the place of the action on.
    """
    if (terms := controller.tegotae) is None:
        return np.array(_push(controller, v, 0.0))
    valid = bool(np.isfinite(v.action * v.reaction * v.gain).all())
    one, two = action_fits(v)
    has_two = isinstance(terms.action, TwoHarmonicsAction)
    fit = two.numbers if has_two else (*one.numbers, 0.0, 0.0)
    offset, a, b, c, d = fit if valid else (0.0, -1.0, 0.0, 0.0, 0.0)
    size = max(math.hypot(a, b), 0.05 * abs(offset), 1e-6)
    turn = (math.atan2(b, a) + math.pi) % TWO_PI
    cosine, sine = math.cos(2.0 * turn), math.sin(2.0 * turn)
    twice = [-(c * cosine + d * sine) / size, -(d * cosine - c * sine) / size]
    numbers = [turn] if isinstance(terms.action, ShiftedAction) else []
    numbers += [] if isinstance(terms.action, VanillaAction) else [-offset / size]
    numbers += twice if has_two else []
    of_nothing = [*np.ones(terms.reaction.n_weights), 0.0]
    numbers += _reaction(terms.reaction, v, size) if valid else of_nothing
    return np.array(numbers if controller.limbs > 1 else [*numbers, *_push(controller, v, turn)])


def _reaction(term: Term, v: Visits, size: float) -> list[float]:
    """Return the numbers of a reaction, and the gain, for an action of some size."""
    fits = reaction_fits(v)
    if isinstance(term, VanillaReaction):
        newtons = v.spring_force_n.max() / max(v.load.max(), 1e-9)
        return [size * fits["load"].numbers[0] / max(newtons, 1e-9)]
    if isinstance(term, DecayingReaction):
        scale, inside = fits["decay"].numbers
        return [inside, size * scale]
    saturates = isinstance(term, SaturatingReaction)
    scale, slope, *inside = fits["saturating" if saturates else "latch"].numbers
    threshold = 0.05 * float(np.abs(v.gain * v.reaction).max())  # what is 0 in flight has no k
    scale = scale if abs(scale) > threshold else math.copysign(max(threshold, 1e-6), scale)
    return [-slope / scale, *inside, size * scale]


def _push(controller: Controller, v: Visits, turn: float) -> list[float]:
    """Return the start of the sector, its width, and the scale of a reflex beside it."""
    _, places = pushing(v, math.inf)
    start, width = (places[0].start_rad, places[0].width_rad) if places else (0.0, 0.5 * math.pi)
    numbers = [(start - turn) % TWO_PI, width]
    if isinstance(controller.actuation, FreeSectorAndReflex):
        outside = v.stance & ((v.phase_rad - start) % TWO_PI > width)
        falling = np.maximum(-v.feedback_rad_per_s, 0.0)[outside]
        power = float(falling @ falling)
        numbers.append(
            float(falling @ v.actuator_force_n[outside]) / power if power > 1e-9 else 0.0
        )
    return numbers


# A form as people and programs write it.

_PLAIN: dict[type[Term], str] = {
    VanillaAction: "cos φ",
    OffsetAction: "(cos φ {plus[0]})",
    TwoHarmonicsAction: "(cos φ {plus[0]} {plus[1]} cos 2φ {plus[2]} sin 2φ)",
    ShiftedAction: "(cos(φ {minus[0]}) {plus[1]})",
    VanillaReaction: "F_k",
    ReversingReaction: "(1 {minus[0]} N)",
    DecayingReaction: "e^({minus[0]} N)",
    SaturatingReaction: "(1 {minus[0]} N / (1 {plus[1]} N))",
}
_LATEX: dict[type[Term], str] = {
    VanillaAction: r"\cos\phi",
    OffsetAction: r"(\cos\phi {plus[0]})",
    TwoHarmonicsAction: r"(\cos\phi {plus[0]} {plus[1]} \cos 2\phi {plus[2]} \sin 2\phi)",
    ShiftedAction: r"(\cos(\phi {minus[0]}) {plus[1]})",
    VanillaReaction: "F_k",
    ReversingReaction: "(1 {minus[0]} N)",
    DecayingReaction: "e^{{{minus[0]} N}}",
    SaturatingReaction: r"\left(1 {minus[0]} \frac{{N}}{{1 {plus[1]} N}}\right)",
}
_C: dict[type[Term], str] = {
    VanillaAction: "cosf(phase)",
    OffsetAction: "(cosf(phase) {plus[0]}f)",
    TwoHarmonicsAction: (
        "(cosf(phase) {plus[0]}f {plus[1]}f * cosf(2.0f * phase) {plus[2]}f * sinf(2.0f * phase))"
    ),
    ShiftedAction: "(cosf(phase {minus[0]}f) {plus[1]}f)",
    VanillaReaction: "spring_force_n",
    ReversingReaction: "(1.0f {minus[0]}f * load)",
    DecayingReaction: "expf({minus[0]}f * load)",
    SaturatingReaction: "(1.0f {minus[0]}f * load / (1.0f {plus[1]}f * load))",
}


def _spelled(
    saved: SavedController, words: dict[type[Term], str], digits: int = 3
) -> tuple[str, str, str]:
    """Return the negative gain, the reaction and the action of the first set of weights."""
    controller, weights = saved.controller, saved.weights
    assert controller.tegotae is not None
    terms = controller.tegotae

    def numbers(role: str, sign: float = 1.0) -> list[str]:
        return [signed(sign * x, digits) for x in weights[controller.layout[role]]]

    reaction, action = (
        words[type(term)].format(plus=numbers(role), minus=numbers(role, -1.0))
        for role, term in (("reaction", terms.reaction), ("action", terms.action))
    )
    return numbers("gain", -1.0)[0], reaction, action


def _pushed(saved: SavedController) -> tuple[float, float, float] | None:
    """Return begin and end of the sector [rad], and the reflex's scale, or None for legs with
    feet.
    """
    if saved.controller.limbs > 1:
        return None
    start, width, *scale = saved.weights[saved.controller.layout["actuation"]]
    return start % TWO_PI, (start + min(max(width, 0.0), TWO_PI)) % TWO_PI, sum(scale)


def plain_law(saved: SavedController) -> str:
    """Return a form as a line of text: N is the load in weights of the body, F_k the spring force
    [N], f the feedback [rad/s].
    """
    law = "φ̇ = ω"
    if saved.controller.tegotae is not None:
        law += f" {' '.join(_spelled(saved, _PLAIN))}"
    if (push := _pushed(saved)) is None:
        return law
    start, end, scale = push
    reflex = f", and {scale:.3g} max(0, -f) N besides" if scale else ""
    return f"{law}, with full force at φ = {start:.2f} ... {end:.2f} rad{reflex}"


def latex(saved: SavedController) -> str:
    """Return a form as LaTeX, the load N in weights of the body."""
    law = r"\dot\phi = \omega"
    if saved.controller.tegotae is not None:
        law += " " + r"\, ".join(_spelled(saved, _LATEX))
    if (push := _pushed(saved)) is None:
        return law
    start, end, scale = push
    reflex = rf" {signed(scale)} \max(0, -f)" if scale else ""
    sector = rf"\alpha\, [\phi \in ({start:.2f}, {end:.2f})]"
    return rf"{law},\quad F = {sector}{reflex}"


def c_line(saved: SavedController) -> str:
    """Return the rate of the phase and the force as lines of C, for reading."""
    feedback = "0.0f"
    if saved.controller.tegotae is not None:
        gain, reaction, action = _spelled(saved, _C, 6)
        feedback = f"{gain.replace('+ ', '').replace('- ', '-')}f * {reaction} * {action}"
    lines = [f"float feedback = {feedback};", "float phase_rate = omega + feedback;"]
    if (push := _pushed(saved)) is not None:
        start, end, scale = push
        join = "&&" if start <= end else "||"
        lines.append(f"int pushes = phase >= {start:.6g}f {join} phase < {end:.6g}f;")
        force = "pushes ? max_force : 0.0f"
        if scale:
            lines.append(f"float reflex = {scale:.6g}f * fmaxf(0.0f, -feedback);")
            force = f"fminf(max_force, fmaxf(0.0f, ({force}) + reflex))"
        lines.append(f"float force = {force};")
    return re.sub(r"(?<![\w.])(?<!e[+-])(\d+)f", r"\1.0f", "\n".join(lines))  # 6f is no C


def python(saved: SavedController) -> str:
    """Return a form as terms of this package with their numbers."""
    weights = [float(f"{x:.6g}") for x in saved.weights]
    return f"SavedController.from_weights({saved.controller!r}, {weights}, omega={saved.omega!r})"
