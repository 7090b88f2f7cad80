"""Policies of SAC and PPO that are a Tegotae law."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import require
from tegotae.parts.controller import Controller
from tegotae.parts.terms import (
    ConstantGain,
    Network,
    Signals,
    Term,
    VanillaAction,
    VanillaReaction,
)
from tegotae.training.agents import AgentSettings, PPOSettings, SACSettings

require("stable_baselines3", "sb3")

import torch  # noqa: E402
from stable_baselines3 import PPO, SAC  # noqa: E402
from stable_baselines3.common.base_class import BaseAlgorithm  # noqa: E402
from stable_baselines3.common.policies import ActorCriticPolicy  # noqa: E402
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor  # noqa: E402
from stable_baselines3.common.type_aliases import Schedule  # noqa: E402
from stable_baselines3.common.vec_env import VecEnv  # noqa: E402
from stable_baselines3.sac.policies import Actor, SACPolicy  # noqa: E402
from torch import nn  # noqa: E402


@dataclass(frozen=True)
class Observed:
    """Meaning of the columns of an observation.

    Args:
        names: of the signals, in the order of the columns; all dimensionless.
        scales: what a signal was divided by.
    """

    names: tuple[str, ...]
    scales: Mapping[str, float]


@dataclass(frozen=True)
class AgentTask:
    """Task of an agent and evaluation of its policy: the hopper, or an environment.

    Args:
        settings: the algorithm and how it is set.
        controller: the policy, with a limit to its feedback (`agent_controller`).
        observed: what the columns of an observation are, of one limb.
        duration_s: length of an episode [s].
        actions_per_episode: actions in a whole episode.
        make_env: makes the episodes side by side in which the agent acts; its action is the
            feedback.
        judge: fitness and CoT⁻¹ [m/J] of the deterministic policy with weights [n_weights].
    """

    settings: AgentSettings
    controller: Controller
    observed: Observed
    duration_s: float
    actions_per_episode: int
    make_env: Callable[[], VecEnv]
    judge: Callable[[np.ndarray], tuple[float, float]]


class TermModule(nn.Module):
    """One term: its weights as one parameter, in the layout of `tegotae.parts.terms`."""

    weights: nn.Parameter

    def __init__(self, term: Term, observed: Observed, weights: np.ndarray) -> None:
        super().__init__()
        self.term = term
        self.weights = nn.Parameter(torch.tensor(weights, dtype=torch.float32))
        self.columns = [observed.names.index(name) for name in term.reads]
        self.scales = [observed.scales.get(name, 1.0) for name in term.reads]

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Map observations [batch, columns] to the term's value, [batch] or [1]."""
        return _FORWARD[type(self.term)](self, observations[:, self.columns])


def _network(module: TermModule, x: torch.Tensor) -> torch.Tensor:
    """Return `Σ_j v_j tanh(Σ_i w_ji x_i + b_j)`; neuron j owns a run of weights w_j1 … w_jn, b_j,
    v_j.
    """
    n = len(module.columns)
    table = module.weights.view(-1, n + 2)
    return torch.tanh(x @ table[:, :n].T + table[:, n]) @ table[:, n + 1]


_FORWARD: dict[type[Term], Callable[[TermModule, torch.Tensor], torch.Tensor]] = {
    Network: _network,
    VanillaAction: lambda module, x: -x[:, 0],  # -cos φ
    VanillaReaction: lambda module, x: x[:, 0] * module.scales[0],  # F_k [N]
    ConstantGain: lambda module, x: module.weights,  # σ
}
"""The usual terms of what they read, [batch, signals], quicker than by JAX (`JaxTermModule`)."""

_ROLES = ("action", "reaction", "gain")


class JaxTermModule(TermModule):
    """Module of a term without a counterpart in torch, by its own function and JAX's gradient
    of it.
    """

    def __init__(self, term: Term, observed: Observed, weights: np.ndarray) -> None:
        super().__init__(term, observed, weights)

        def value(weights: jax.Array, columns: jax.Array) -> jax.Array:
            batch = columns.shape[:1]
            scaled = zip(term.reads, columns.T, self.scales, strict=True)
            scales = {name: observed.scales[name] for name in term.reads if name in observed.scales}
            signals = Signals({name: column * scale for name, column, scale in scaled}, scales)
            rows = [jnp.broadcast_to(weight, batch) for weight in weights]
            return jnp.broadcast_to(term(rows, signals), batch)

        def pull(weights: jax.Array, columns: jax.Array, gradient: jax.Array) -> jax.Array:
            return jax.vjp(lambda w: value(w, columns), weights)[1](gradient)[0]

        self.value, self.pull = jax.jit(value), jax.jit(pull)

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Map observations [batch, columns] to the term's value, [batch]."""
        return _ThroughJax.apply(self.weights, observations[:, self.columns], self)


class _ThroughJax(torch.autograd.Function):
    """A function of JAX in a graph of torch; observations need no gradient."""

    @staticmethod
    def forward(
        ctx: Any, weights: torch.Tensor, columns: torch.Tensor, module: JaxTermModule
    ) -> torch.Tensor:
        ctx.save_for_backward(weights, columns)
        ctx.module = module
        return _to_torch(module.value(_to_numpy(weights), _to_numpy(columns)))

    @staticmethod
    def backward(ctx: Any, *gradients: torch.Tensor) -> tuple[torch.Tensor, None, None]:
        weights, columns = ctx.saved_tensors
        gradients_in = ctx.module.pull(*map(_to_numpy, (weights, columns, gradients[0])))
        return _to_torch(gradients_in), None, None


def _to_numpy(tensor: torch.Tensor) -> np.ndarray:
    return tensor.detach().cpu().numpy()


def _to_torch(array: jax.Array) -> torch.Tensor:
    return torch.from_numpy(np.array(array))


class Feedback(nn.Module):
    """`G · A′(φ) · R(s) / L` of observations: the feedback as a share of its limit, unsaturated.

    Limbs share their weights. An observation has the columns of one limb after the other; what
    comes behind is for critics alone.

    Args:
        controller: one with a limit L and an actuation without weights.
        observed: what the columns of one limb are.
        weights: of the controller, shape [n_weights].
    """

    def __init__(
        self, controller: Controller, observed: Observed, weights: Sequence[float] | np.ndarray
    ) -> None:
        super().__init__()
        assert controller.tegotae is not None
        assert controller.tegotae.limit_rad_per_s is not None
        self.limit, self.limbs = controller.tegotae.limit_rad_per_s, controller.limbs
        self.columns = self.limbs * len(observed.names)
        flat = np.asarray(weights, np.float32)
        terms = []
        for role in _ROLES:
            term = controller.terms[role]
            kind = TermModule if type(term) in _FORWARD else JaxTermModule
            terms.append(kind(term, observed, flat[controller.layout[role]]))
        self.terms = nn.ModuleList(terms)

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Map observations [batch, columns] to G A′ R / L, [batch, limbs]."""
        if self.limbs > 1:
            inputs = observations[:, : self.columns]
            observations = inputs.reshape(len(inputs) * self.limbs, -1)
        action, reaction, gain = (term(observations) for term in self.terms)
        return (gain * action * reaction / self.limit).reshape(-1, self.limbs)

    def flat(self) -> np.ndarray:
        """Return the controller's weights, float32 [n_weights]."""
        parts = [term.weights.detach().cpu().numpy() for term in self.terms]  # type: ignore[union-attr]
        return np.concatenate(parts)


def _taken_by(algorithm: type[BaseAlgorithm], settings: AgentSettings) -> dict[str, Any]:
    """Return the settings that have the same name in Stable-Baselines3."""
    names = signature(algorithm).parameters
    return {name: value for name, value in vars(settings).items() if name in names}


class FeedbackPPOPolicy(ActorCriticPolicy):
    """SB3's policy, its actor a Gaussian of learned, constant deviation around tanh(G A′ R / L)."""

    def __init__(self, *args: Any, feedback: Feedback, **options: Any) -> None:
        # Modules cannot be assigned before SB3's constructor, which already builds the networks.
        self._parts = (feedback,)
        super().__init__(*args, **options)

    def _build(self, lr_schedule: Schedule) -> None:
        super()._build(lr_schedule)
        self.action_net = nn.Sequential(*self._parts, nn.Tanh())
        self.optimizer = self.optimizer_class(
            self.parameters(),
            lr=lr_schedule(1),  # type: ignore[call-arg]
            **self.optimizer_kwargs,
        )


def make_ppo(settings: PPOSettings, env: VecEnv, feedback: Feedback, seed: int) -> PPO:
    """Make the agent, untrained."""
    return PPO(
        FeedbackPPOPolicy,
        env,
        **_taken_by(PPO, settings),
        policy_kwargs={
            "feedback": feedback,
            "log_std_init": math.log(settings.noise),
            "net_arch": {"pi": [], "vf": list(settings.critic_layers)},
        },
        seed=seed,
        device="cpu",
    )


class _StateIndependent(nn.Module):
    """Module with the same output for every observation."""

    def __init__(self, value: float) -> None:
        super().__init__()
        self.value = nn.Parameter(torch.tensor([value]))

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Map observations [batch, columns] to the number, [batch, 1]."""
        return self.value.expand(observations.shape[0], 1)


class FeedbackSACPolicy(SACPolicy):
    """SB3's policy, its actor `tanh(G A′ R / L + noise)` with a learned, constant deviation."""

    def __init__(self, *args: Any, feedback: Feedback, noise: float, **options: Any) -> None:
        # Modules cannot be assigned before SB3's constructor, which already asks for the actor.
        self._parts = (feedback, noise)
        super().__init__(*args, **options)

    def make_actor(self, features_extractor: BaseFeaturesExtractor | None = None) -> Actor:
        """Make SB3's actor with the feedback law in place of its network."""
        actor = super().make_actor(features_extractor)
        feedback, noise = self._parts
        actor.mu = feedback  # type: ignore[assignment]
        actor.log_std = _StateIndependent(math.log(noise))  # type: ignore[assignment]
        return actor.to(self.device)


def make_sac(settings: SACSettings, env: VecEnv, feedback: Feedback, seed: int) -> SAC:
    """Make the agent, untrained."""
    options = _taken_by(SAC, settings)
    options |= {"target_entropy": settings.target_entropy * feedback.limbs}
    return SAC(
        FeedbackSACPolicy,
        env,
        **options,
        n_steps=settings.td_steps,
        policy_kwargs={
            "feedback": feedback,
            "noise": settings.noise,
            "net_arch": {"pi": [], "qf": list(settings.critic_layers)},
            # One call for all parameters: networks as small as these are all overhead.
            "optimizer_kwargs": {"fused": True},
        },
        seed=seed,
        device="cpu",
    )
