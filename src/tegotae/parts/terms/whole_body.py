"""One network for the whole body: it feels all legs, and commands all of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import Weights
from tegotae.parts.channels import FOOT
from tegotae.parts.parameters import a_part, numbers, positive, whole
from tegotae.parts.terms.actuation import Actuation
from tegotae.parts.terms.base import Signals
from tegotae.parts.terms.foot import AddedToEllipse, EllipticFoot
from tegotae.parts.terms.network import as_read
from tegotae.parts.weight_names import WeightName


@dataclass(frozen=True)
class WholeBody(Actuation):
    """A network with one tanh layer over all legs, `u_k = Σ_j v_jk tanh(Σ_i w_ji x_i + b_j)`.

    It is what a decentralised controller is compared with: the only actuation that looks from one
    leg to another. Its inputs are what every leg feels, leg by leg, and what the body feels as a
    whole; its outputs are every leg's force [N]. All units of the controller share its weights.

    Args:
        of_each: names of signals that are read of every leg, such as ("spring_force",).
        of_body: names of those that are the same for all legs, such as ("pitch", "roll"), and of
            the first leg's oscillator, ("phase",): a clock.
        limbs: how many legs there are.
        hidden: number of hidden neurons h.

    Raises:
        TegotaeError: for no inputs, fewer than two legs, or fewer than one hidden neuron.

    Source: the single network of the paper (IV-A), for a body with several legs.

    Example:
        >>> WholeBody(("spring_force",), ("phase",), limbs=4, hidden=8).n_weights
        88
    """

    of_each: tuple[str, ...]
    of_body: tuple[str, ...]
    limbs: int = whole(least=2)
    hidden: int = whole()

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (*self.of_each, *self.of_body):
            raise TegotaeError("a network has no inputs; name at least one signal")

    def check(self, limbs: int, sets: int) -> None:
        """Raise `TegotaeError` for other legs than its own, or legs with weights of their own."""
        if limbs != self.limbs:
            raise TegotaeError(
                f"the {type(self).__name__} commands {self.limbs} limbs; the controller has {limbs}"
            )
        if sets > 1:
            raise TegotaeError(
                f"the {type(self).__name__} is one network for all limbs; leave sharing out"
            )

    @property
    def reads(self) -> tuple[str, ...]:
        """Signals read, the phase as its sine and cosine."""
        return (*as_read(self.of_each), *as_read(self.of_body))

    @property
    def _outputs(self) -> int:
        return self.limbs * len(self.COMMANDS)

    @property
    def n_inputs(self) -> int:
        """Number of inputs of the network."""
        return self.limbs * len(as_read(self.of_each)) + len(as_read(self.of_body))

    @property
    def n_weights(self) -> int:
        """h·(inputs + 1 + outputs)."""
        return self.hidden * (self.n_inputs + 1 + self._outputs)

    @property
    def weight_names(self) -> tuple[WeightName, ...]:
        """Names of the weights: of each neuron one per input, the bias, and one per output."""
        inputs = [(name, leg) for name in as_read(self.of_each) for leg in range(self.limbs)]
        out = [(name, leg) for name in self.COMMANDS for leg in range(self.limbs)]
        entries = (
            *(("leg", leg, name) for name, leg in inputs),
            *((name,) for name in as_read(self.of_body)),
            ("bias",),
            *(("output", leg, name) for name, leg in out),
        )
        return tuple(("neuron", j, *path) for j in range(self.hidden) for path in entries)

    def initial(self, key: jax.Array) -> jax.Array:
        """Return normal weights of standard deviation 1/√inputs (output: 1/√h), biases
        normal(0, 0.5).
        """
        inputs = [self.n_inputs**-0.5] * self.n_inputs
        per_neuron = jnp.array([*inputs, 0.5, *[self.hidden**-0.5] * self._outputs])
        normal = jax.random.normal(key, (self.hidden, len(per_neuron)))
        return (normal * per_neuron[None, :]).reshape(-1)

    def outputs(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return every command of every leg, [commands, limbs, lanes]."""
        legs = [signals.dimensionless(name) for name in as_read(self.of_each)]
        body = [signals.dimensionless(name)[0] for name in as_read(self.of_body)]
        x = [felt[leg] for felt in legs for leg in range(self.limbs)] + body
        stride = self.n_weights // self.hidden
        total = None
        for j in range(self.hidden):
            # Units share the weights: those of the first are those of all.
            weights_of_output = [weight[0] for weight in weights[j * stride : (j + 1) * stride]]
            drive = weights_of_output[len(x)]
            for w, x_i in zip(weights_of_output, x, strict=False):
                drive = drive + w * x_i
            output = jnp.stack(weights_of_output[len(x) + 1 :]) * jnp.tanh(drive)[None]
            total = output if total is None else total + output
        assert total is not None  # there is one neuron at least
        return total.reshape(len(self.COMMANDS), self.limbs, *total.shape[1:])

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return the forces [N], [limbs, lanes]."""
        return self.outputs(weights, signals)[0]


@dataclass(frozen=True)
class WholeBodyFoot(WholeBody):
    """The same for legs whose feet are commanded to places.

    Args:
        reach_m: by what the outputs are multiplied [m], as of a `LearnedFoot`.

    Raises:
        TegotaeError: for what a `WholeBody` refuses, or a reach that is not positive.

    Source: as of `WholeBody`; the places are those of `LearnedFoot`.
    """

    COMMANDS = FOOT

    reach_m: float = positive(0.1)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Forward and up [m], [2, limbs, lanes]."""
        return self.reach_m * self.outputs(weights, signals)


@dataclass(frozen=True)
class WholeBodyCorrectedFoot(AddedToEllipse, WholeBodyFoot):
    """An ellipse for every leg, all driven by one clock, and what one network adds to them.

    The clock is the first leg's oscillator, φ; leg i is at φ + λ_i on its ellipse, whatever the
    other oscillators do. Its random weights to start from add nothing: training begins with a gait
    of fixed lags.

    Args:
        around: the ellipse.
        lead_rad: by how much each leg leads the clock λ_i [rad], a number a leg.

    Raises:
        TegotaeError: for what a `WholeBodyFoot` refuses, what is no ellipse, or leads of another
            number of legs.

    Source: of this library; the ellipse is that of `EllipticFoot`.

    Example:
        >>> trot = (0.0, math.pi, math.pi, 0.0)
        >>> WholeBodyCorrectedFoot(("spring_force",), ("phase",), 4, 6, lead_rad=trot).n_weights
        90
    """

    around: EllipticFoot = a_part(EllipticFoot, "an EllipticFoot", EllipticFoot)
    lead_rad: tuple[float, ...] = numbers(())

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.lead_rad) != self.limbs:
            raise TegotaeError(
                f"lead_rad has {len(self.lead_rad)} numbers; give it {self.limbs}, one a leg"
            )

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Forward and up [m], [2, limbs, lanes]."""
        sine, cosine = signals["sin_phase"][0], signals["cos_phase"][0]
        places = [
            self.around.place(
                math.cos(lead) * sine + math.sin(lead) * cosine,
                math.cos(lead) * cosine - math.sin(lead) * sine,
            )
            for lead in self.lead_rad
        ]
        return jnp.stack(places, axis=1) + super().__call__(weights, signals)
