"""The feedback law as a torch module: the same terms and weights, and gradients."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tegotae.controller import Controller
from tegotae.errors import TegotaeError
from tegotae.extras import require
from tegotae.terms import ConstantGain, Network, Term, VanillaAction, VanillaReaction

require("stable_baselines3", "sb3")

import torch  # noqa: E402
from torch import nn  # noqa: E402


@dataclass(frozen=True)
class Observed:
    """What the columns of an observation are.

    Args:
        names: of the signals, in the order of the columns; all dimensionless.
        scales: what a signal was divided by.
    """

    names: tuple[str, ...]
    scales: Mapping[str, float]

    def column(self, name: str) -> int:
        """The column in which a signal stands."""
        return self.names.index(name)


class TermModule(nn.Module):
    """One term: its weights as one parameter, in the layout of `tegotae.terms`."""

    weights: nn.Parameter

    def __init__(self, term: Any, observed: Observed, weights: np.ndarray) -> None:
        super().__init__()
        self.weights = nn.Parameter(torch.tensor(weights, dtype=torch.float32))
        self.columns = [observed.column(name) for name in term.reads]
        self.scales = [observed.scales.get(name, 1.0) for name in term.reads]


class NetworkModule(TermModule):
    """`Σ_j v_j tanh(Σ_i w_ji x_i + b_j)`; neuron j owns a run of weights w_j1 … w_jn, b_j, v_j."""

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Observations [batch, columns] to the network's output [batch]."""
        n = len(self.columns)
        table = self.weights.view(-1, n + 2)
        drive = observations[:, self.columns] @ table[:, :n].T + table[:, n]
        return torch.tanh(drive) @ table[:, n + 1]


class VanillaActionModule(TermModule):
    """-cos φ."""

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Observations [batch, columns] to -cos φ, [batch]."""
        return -observations[:, self.columns[0]]


class VanillaReactionModule(TermModule):
    """F_k [N]."""

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Observations [batch, columns] to F_k [N], [batch]."""
        return observations[:, self.columns[0]] * self.scales[0]


class ConstantGainModule(TermModule):
    """σ."""

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Observations [batch, columns] to σ, [1]."""
        return self.weights


MODULES: dict[type[Term], Callable[..., TermModule]] = {
    Network: NetworkModule,
    VanillaAction: VanillaActionModule,
    VanillaReaction: VanillaReactionModule,
    ConstantGain: ConstantGainModule,
}
"""The torch counterpart of each kind of term."""

_ROLES = ("action", "reaction", "gain")


class Feedback(nn.Module):
    """`G · A′(φ) · R(s) / L` of observations: the feedback as a share of its limit, unsaturated.

    Args:
        controller: one with a limit L and an actuation without weights.
        observed: what the observation's columns are.
        weights: of the controller, shape [n_weights].

    Raises:
        TegotaeError: for a term that has no torch counterpart.
    """

    def __init__(
        self, controller: Controller, observed: Observed, weights: Sequence[float] | np.ndarray
    ) -> None:
        super().__init__()
        assert controller.tegotae is not None
        assert controller.tegotae.limit_rad_per_s is not None
        self.limit = controller.tegotae.limit_rad_per_s
        flat = np.asarray(weights, np.float32)
        terms = []
        for role in _ROLES:
            term = controller.terms[role]
            kind = MODULES.get(type(term))
            if kind is None:
                raise TegotaeError(
                    f"an agent cannot learn a {type(term).__name__}: it has no counterpart in "
                    "tegotae.training.agents.actor.MODULES"
                )
            terms.append(kind(term, observed, flat[controller.layout[role]]))
        self.terms = nn.ModuleList(terms)

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Observations [batch, columns] to G A′ R / L, [batch, 1]."""
        action, reaction, gain = (term(observations) for term in self.terms)
        return (gain * action * reaction / self.limit).unsqueeze(1)

    def flat(self) -> np.ndarray:
        """The controller's weights, float32 [n_weights]."""
        parts = [term.weights.detach().cpu().numpy() for term in self.terms]  # type: ignore[union-attr]
        return np.concatenate(parts)
