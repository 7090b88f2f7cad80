"""The page: controllers, bodies, engines and scripts in one HTML file."""

from __future__ import annotations

import base64
import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import jax
import numpy as np

from apps.playground import engine_cache
from apps.playground.bodies import (
    STANDARD,
    Shown,
    losing_legs,
    of_same_form,
)
from apps.playground.compiler import has_compiler
from apps.playground.program import Program
from apps.playground.scripts import bundle_scripts, read_source
from tegotae import __version__
from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError
from tegotae._support.pages import as_script, filled_page
from tegotae.measures.hopping.hopping import HOP_CLEARANCE, REST_SHARE
from tegotae.measures.hopping.signals import MAIN_LOBE_BINS, REST_RANGE_M
from tegotae.measures.objectives.fitness import (
    EPISODE,
    SETTLE_S,
    STRIDE,
    TIE_BREAK,
)
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.measures.optimum import curve
from tegotae.parts.bodies import Body, Hopper
from tegotae.parts.controller import Controller
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.training.settings import tuned

STARTS = 8
"""Number of initial weights for learning in the page: those of the package's seeds."""
GENERATIONS = 150
"""Number of generations of learning in the page."""


@dataclass(frozen=True)
class ControllerChoice:
    """A controller that a page offers.

    Args:
        label: what the page calls it.
        saved: the controller, its weights, frequency and body.
    """

    label: str
    saved: SavedController


@dataclass
class Page:
    """Content of a page: controllers on the standard bodies, and on their own.

    Of several controllers of a kind of body, the first one's numbers are those that it begins with.

    Args:
        choices: the controllers, at least one.
        report: where lines for people go.

    Raises:
        TegotaeError: for a controller that cannot be shown, by its name.
    """

    choices: Sequence[ControllerChoice]
    report: Callable[[str], None] = print
    """Receives a line per slow step, and per controller that a body does not offer."""

    def __post_init__(self) -> None:
        if not self.choices:
            raise TegotaeError("no controllers were given; a playground needs at least one")
        self._engines: dict[str, engine_cache.CompiledEngine] = {}
        self._bodies: dict[str, Body] = dict(STANDARD)
        for choice in self.choices:
            self._know(choice)

    def html(self) -> str:
        """Return the HTML file.

        Raises:
            TegotaeError: for an engine that cannot be made.
        """
        return filled_page(
            read_source("page.html"),
            {
                "STYLE": read_source("style.css"),
                "DATA": as_script(self.document()),
                "WORKER": _in_a_script(bundle_scripts("learn/worker.js")),
                "SCRIPT": _in_a_script(bundle_scripts("main.js")),
            },
        )

    def document(self) -> JsonObject:
        """Return all data of the scripts, as plain JSON values."""
        controllers = [self._controller(choice) for choice in self.choices]
        return {
            "version": __version__,
            "bodies": [self._body(name, body) for name, body in self._bodies.items()],
            "controllers": controllers,
            "engines": {
                name: {"wasm": base64.b64encode(engine.wasm).decode(), "layout": engine.layout}
                for name, engine in self._engines.items()
            },
            "definitions": DEFINITIONS,
            "learning": _learning(),
        }

    def _know(self, choice: ControllerChoice) -> None:
        """Add the body of a controller, as the page begins with it."""
        body = losing_legs(choice.saved.body)
        for name, standard in self._bodies.items():
            if of_same_form(standard, body):
                if standard is STANDARD.get(name) and body != STANDARD[name]:
                    self._bodies[name] = body
                return
        Shown(choice.label, body)  # refuses what cannot be drawn
        self._bodies[choice.label] = body

    def _body(self, name: str, body: Body) -> JsonObject:
        program = Program(_any_controller(body), body)
        return Shown(name, body).document(program.pose_names, program.numbers)

    def _controller(self, choice: ControllerChoice) -> JsonObject:
        saved = choice.saved
        controller = saved.controller
        engines = {}
        for name, body in self._bodies.items():
            fitted = _fitted(saved, body)
            if fitted is None:
                continue
            if not engine_cache.has(fitted, body) and has_compiler():
                self.report(f"compiling {choice.label} on the {name}")
            try:
                engines[name] = self._engine(fitted, body)
            except TegotaeError as error:
                if of_same_form(body, losing_legs(saved.body)):
                    raise TegotaeError(f"{choice.label}: {error}") from None
                self.report(f"{choice.label} is not offered on the {name}: {error}")
        weights = np.asarray(saved.weights, np.float32)
        return {
            "label": choice.label,
            "omega": saved.omega,
            "weights": _numbers(weights),
            "sigma": _sigma(controller),
            "engines": engines,
            "rhythm": controller.oscillator is not None,
            "starts": _starts(controller)
            if controller.limbs == 1 and controller.n_weights > 1
            else [],
        }

    def _engine(self, controller: Controller, body: Body) -> str:
        name = engine_cache.engine_name(controller, body)
        if name not in self._engines:
            self._engines[name] = engine_cache.cached_engine(controller, body)
        return name


DEFINITIONS: JsonObject = {
    "hop_clearance": HOP_CLEARANCE,
    "rest_share": REST_SHARE,
    "rest_range_m": REST_RANGE_M,
    "lobe_bins": MAIN_LOBE_BINS,
    "tie_break": TIE_BREAK,
    "stride": STRIDE,
    "failed_fitness": FAILED_FITNESS,
}
"""Numbers of the package's measures, which the page's scripts take from here."""


def _learning() -> JsonObject:
    """Return the settings of learning in the page, equal to those of `tegotae train`, and the best
    known fitness."""
    settings = dataclasses.asdict(tuned("pgpe"))
    timing = {**dataclasses.asdict(EPISODE), "settle_s": SETTLE_S}
    best = curve()
    rows = np.isfinite(best["cot_inverse"])
    optimum = {name: _numbers(best[name][rows]) for name in ("omega", "cot_inverse")}
    return {
        "settings": settings,
        "timing": timing,
        "generations": GENERATIONS,
        "optimum": optimum,
        "of_body": dataclasses.asdict(Hopper()),
    }


def _fitted(saved: SavedController, body: Body) -> Controller | None:
    """Return the controller for a body: its own, or the one leg's under every leg of a frame."""
    controller = saved.controller
    if of_same_form(body, losing_legs(saved.body)):
        return controller
    if controller.limbs == 1 and isinstance(saved.body, Hopper):
        return dataclasses.replace(controller, limbs=body.limbs)
    return None


def _any_controller(body: Body) -> Controller:
    return dataclasses.replace(recipe("V-sector-w8").controller(), limbs=body.limbs)


def _sigma(controller: Controller) -> int | None:
    """Return the index of σ among the weights; None without one."""
    names = controller.weight_names
    return names.index(("gain", "sigma")) if ("gain", "sigma") in names else None


def _starts(controller: Controller) -> list[list[float]]:
    """Return the initial weights of trainings of the first seeds
    (`training.evolution.Evolution.start`)."""
    keys = [jax.random.split(jax.random.key(seed))[0] for seed in range(STARTS)]
    return [_numbers(np.asarray(controller.initial(key))) for key in keys]


def _numbers(values: np.ndarray) -> list[float]:
    """Return numbers with as many digits as a float32 needs."""
    return [float(f"{x:.9g}") for x in np.asarray(values, np.float64).reshape(-1)]


def _in_a_script(text: str) -> str:
    """Return a script of the package that ends no script element early."""
    return text.replace("</", "<\\/")
