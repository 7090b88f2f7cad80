"""The contract of a controller on a body."""

from __future__ import annotations

import jax
import numpy as np

from tegotae._support.errors import TegotaeError, is_of
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.parts.terms.actuation import Actuation
from tegotae.simulation.checks.body import check_body
from tegotae.simulation.checks.parts import check_oscillator, check_term
from tegotae.simulation.rollout import (
    Engine,
    Scenario,
    Timing,
    check_senses,
)


def check_controller(controller: Controller, body: Body) -> None:
    """Check every part of a controller, its body, and a short rollout of both together.

    Checked are: `check_term` for each term, `check_oscillator`; that the body senses all that the
    terms read; `check_body`; and that 0.1 s with random weights stays finite in one lane while
    another lane's weights are NaN.

    Args:
        controller: what drives the body.
        body: the body.

    Raises:
        TegotaeError: for the first breach, with what would be right.

    Example:
        >>> import tegotae
        >>> check_controller(tegotae.build("V-reflex-w4"), tegotae.Hopper())
    """
    if not is_of(controller, Controller):
        raise TegotaeError(
            f"{type(controller).__name__} is no Controller; make one of terms: "
            "Controller(actuation, oscillator, Tegotae(action, reaction, gain))"
        )
    for term in controller.terms.values():
        check_term(term)
    if not is_of(controller.actuation, Actuation):
        raise TegotaeError(
            f"{type(controller.actuation).__name__} cannot be the actuation; make it a subclass of "
            "tegotae.parts.terms.Actuation"
        )
    if controller.tegotae is not None and controller.oscillator is None:
        raise TegotaeError("the controller has Tegotae terms but no oscillator for them to drive")
    if controller.oscillator is not None:
        check_oscillator(controller.oscillator)
    check_senses(controller, body)
    check_body(body)
    _check_rollout(controller, body)


def _check_rollout(controller: Controller, body: Body) -> None:
    engine = Engine(controller=controller, timing=Timing(duration_s=0.1))
    weights = np.repeat(np.asarray(controller.initial(jax.random.key(0)))[None], 2, axis=0)
    scenario = Scenario(omega=5.0, height_m=1.01 * float(body.rest_length_m))
    sound = engine.run(weights, scenario, body)
    if bool(sound.failed.any()):
        raise TegotaeError(
            "the rollout with the controller's initial weights fails within 0.1 s of its release "
            "just over the ground; check the body's `failed` and the size of the forces"
        )
    weights[1] = np.nan
    spoiled = engine.run(weights, scenario, body)
    if not np.array_equal(sound.height_m[:, 0], spoiled.height_m[:, 0]):
        raise TegotaeError("a lane with NaN weights changes another lane; keep terms elementwise")
