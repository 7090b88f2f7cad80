"""An actuation of your own: a half sine of force, whose amplitude is a weight."""

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from tegotae import Controller, Rollout, Scenario, Timing, check
from tegotae.figures.style import COLOURS, new_figure, save_figure, styled
from tegotae.parts.controller import Tegotae
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import Actuation, ConstantGain, Signals, VanillaAction, VanillaReaction


@dataclass(frozen=True)
class HalfSine(Actuation):
    """`F_a = F max(0, -sin φ)`, with a weight F [N]."""

    @property
    def reads(self) -> tuple[str, ...]:
        """Signals that it reads."""
        return ("sin_phase",)

    @property
    def n_weights(self) -> int:
        """Number of trained weights."""
        return 1

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        """The force [N]."""
        return weights[0] * jnp.maximum(-signals["sin_phase"], 0.0)


check(HalfSine())
feedback = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
controller = Controller(HalfSine(), PhaseOscillator(), feedback)

# A lane for each amplitude: all are simulated at once.
force_n = np.linspace(0.2, 4.0, 39)
weights = np.stack([np.full_like(force_n, 2.0), force_n], axis=1)  # the gain σ, and F
rollout = Rollout(controller=controller, timing=Timing(duration_s=20.0))
path = rollout.run(weights, Scenario(omega=8.0))
apex_m = np.fmax(np.nanmax(np.nan_to_num(path.apex_height_m[-250:]), axis=0), 1.0)

with styled():
    figure = new_figure(4.0, 2.4)
    axes = figure.subplots()
    axes.plot(force_n, apex_m, "o-", color=COLOURS[0], ms=3)
    axes.set(xlabel="amplitude F [N]", ylabel="highest apex [m]")
save_figure(figure, "own_term.png")
print(f"with 4 N it hops to {apex_m[-1]:.2f} m")
assert apex_m[0] < 1.01 < apex_m[-1]  # a weak half sine does not lift the leg, a strong one does
