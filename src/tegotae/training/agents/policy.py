"""The policy that an agent learns: a model's controller with a limit to its feedback."""

from __future__ import annotations

import dataclasses

import jax
import numpy as np

from tegotae.controller import Controller
from tegotae.errors import TegotaeError
from tegotae.models import BUDGET, Model


def agent_controller(
    model: Model, algorithm: str, limit_rad_per_s: float, budget: int = BUDGET
) -> Controller:
    """The model's controller as an agent's deterministic policy, `f = L tanh(G A′ R / L)`.

    It has the weights of the model's own controller; only its feedback saturates, for an agent's
    action is bounded.

    Args:
        algorithm: the algorithm's name, for the error.
        limit_rad_per_s: L.
        budget: largest number of weights.

    Raises:
        TegotaeError: for a model without a meaning for an agent whose action is the feedback.

    Example:
        >>> from tegotae.models import find
        >>> controller = agent_controller(find("AR"), "sac", 40.0)
        >>> controller.n_weights, controller.tegotae.limit_rad_per_s
        (96, 40.0)
    """
    without = f"{algorithm} has no meaning for {model.name}:"
    if model.is_single_network:
        raise TegotaeError(
            f"{without} an agent's action is the Tegotae feedback, and it has none; use pgpe"
        )
    if not model.is_trained:
        raise TegotaeError(
            f"{without} it has no network to learn; its gain is found by search, with pgpe"
        )
    if model.learned_actuation:
        raise TegotaeError(
            f"{without} the weights of its actuation lie behind the agent's action, the feedback, "
            "where no gradient reaches them; use pgpe"
        )
    controller = model.controller(budget)
    assert controller.tegotae is not None
    tegotae = dataclasses.replace(controller.tegotae, limit_rad_per_s=limit_rad_per_s)
    return dataclasses.replace(controller, tegotae=tegotae)


def initial_weights(controller: Controller, seed: int) -> np.ndarray:
    """The weights that the training of this seed starts from, by whatever algorithm, [n_weights].

    They are those of `tegotae.training.evolve.start`, to rounding.
    """
    key_weights, _ = jax.random.split(jax.random.key(seed))
    return np.asarray(controller.initial(key_weights), np.float32)
