"""The policy that an agent learns: a controller with a limit to its feedback."""

from __future__ import annotations

import dataclasses

import jax
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts.controller import Controller
from tegotae.systems.registry import name_of
from tegotae.training.agents.settings import AgentSettings
from tegotae.training.trainable import Trainable


def agent_controller(experiment: Trainable, settings: AgentSettings) -> Controller:
    """An experiment's controller as an agent's deterministic policy, `f = L tanh(G A′ R / L)`.

    It has the weights of the experiment's own controller; only its feedback saturates at the
    settings' L, for an agent's action is bounded.

    Raises:
        TegotaeError: for a controller without a meaning for an agent whose action is the feedback.

    Example:
        >>> from tegotae.systems.models import find
        >>> from tegotae.training.agents import SACSettings
        >>> controller = agent_controller(find("AR").experiment(), SACSettings())
        >>> controller.n_weights, controller.tegotae.limit_rad_per_s
        (96, 40.0)
    """
    controller = experiment.controller
    without = f"{name_of(type(settings))} has no meaning for {experiment.name}:"
    if controller.tegotae is None:
        raise TegotaeError(
            f"{without} an agent's action is the Tegotae feedback, and it has none; use pgpe"
        )
    if experiment.is_searched:
        raise TegotaeError(
            f"{without} it has no network to learn; its gain is found by search, with pgpe"
        )
    if controller.actuation.n_weights:
        raise TegotaeError(
            f"{without} the weights of its actuation come after the agent's action, the feedback, "
            "where no gradient reaches them; take a model without, such as AR, or use pgpe"
        )
    if controller.sets > 1 or controller.coupling is not None:
        raise TegotaeError(
            f"{without} its limbs have weights of their own or a coupling, and an agent learns one "
            "law for all of them; use pgpe"
        )
    limit = settings.max_feedback_rad_per_s
    tegotae = dataclasses.replace(controller.tegotae, limit_rad_per_s=limit)
    return dataclasses.replace(controller, tegotae=tegotae)


def initial_weights(controller: Controller, seed: int) -> np.ndarray:
    """The weights that the training of this seed starts from, by whatever algorithm, [n_weights].

    They are those of `tegotae.training.evolve.start`, to rounding.
    """
    key_weights, _ = jax.random.split(jax.random.key(seed))
    return np.asarray(controller.initial(key_weights), np.float32)
