"""Laws of the feet that react to the loss of a leg: what a vector of numbers means, and its score.

A foot's place is an ellipse, and what two small networks add to it. All legs have the same weights;
or left and right legs mirror images of each other, so that a leg knows its side; or fore and hind
legs have weights of their own besides, so that it knows its place. No foot is shifted by more than
`SHIFT_M` or lifted by more than `LIFT_M`, whatever the weights.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Literal

import jax.numpy as jnp
import numpy as np

from tegotae.parts.terms import CorrectedFoot, EllipticFoot
from tegotae.simulation.recorder import needing
from tegotae.simulation.rollout import Timing
from tegotae.simulation.schedules import Step
from tegotae.simulation.world import with_changes
from tegotae.systems.legged import Legged, random_phases

SHIFT_M, LIFT_M = 0.5, 0.2
"""Largest shift of a foot by a network, fore and aft, and up and down [l0]."""
TYPICAL = {
    "spring_force": 0.25,
    "pitch": 0.15,
    "roll": 0.15,
    "pitch_rate": 0.3,
    "roll_rate": 0.3,
}
"""Sizes of what is felt: a weight of one turns them into one."""
MIRRORED = ("roll", "roll_rate")
"""Senses that have the other sign for the legs of the other side."""
LOST_S = 20.0
"""Time at which a leg is lost in training [√(l0/g)]."""
TIMING = Timing(duration_s=45.0, tick_s=0.0125, frame_s=0.5)
"""Timing of a training episode."""
UNSEEN = 10_000
"""Seeds of phases from here on are of the training; those of the evaluation are small."""


@dataclass(frozen=True)
class Law:
    """A form of law, and how vectors of numbers of about one in size become its weights.

    Args:
        name: of its rows, runs and controllers.
        about: in a line.
        around: the ellipse.
        senses: what a foot feels.
        hidden: neurons of each of its two networks.
        knows: what a leg knows of itself: nothing, its side, or its place.
    """

    name: str
    about: str
    around: EllipticFoot
    senses: tuple[str, ...]
    hidden: int
    knows: Literal["nothing", "side", "place"] = "nothing"

    def legged(self, vanilla: Legged, weights: np.ndarray) -> Legged:
        """Return the quadruped with feet of this form."""
        foot = CorrectedFoot(self.senses, self.hidden, reach_m=1.0, around=self.around)
        sharing = {"nothing": None, "side": (0, 1, 0, 1), "place": (0, 1, 2, 3)}[self.knows]
        controller = dataclasses.replace(vanilla.controller, actuation=foot, sharing=sharing)
        system = dataclasses.replace(vanilla.system, controller=controller)
        return dataclasses.replace(
            vanilla, about=self.about, system=system, weights=tuple(map(float, weights))
        )

    @property
    def unit(self) -> int:
        """Return the number of a vector's entries for a leg's networks and its σ."""
        return 1 + 2 * self.hidden * (len(self.senses) + 2)

    @property
    def ends(self) -> int:
        """Return the number of ends, fore and hind, with separate weights."""
        return 2 if self.knows == "place" else 1

    @property
    def size(self) -> int:
        """Return the length of a vector."""
        return self.ends * self.unit

    def weights(self, x: np.ndarray, sigma: float) -> np.ndarray:
        """Return the weights of the controller [lanes, n_weights] of vectors [lanes, size].

        Args:
            x: the vectors; zero stands for vanilla feedback.
            sigma: the gain that a vector changes by factors of e.
        """
        sides = (False,) if self.knows == "nothing" else (False, True)
        ends = np.split(x, self.ends, axis=1)
        units = [self._leg_weights(end, sigma, mirror) for end in ends for mirror in sides]
        return np.concatenate(units, axis=1)

    def _leg_weights(self, x: np.ndarray, sigma: float, mirror: bool) -> np.ndarray:
        """Return the weights of a leg [lanes, unit]; those of a right one are mirrored."""
        neurons = x[:, 1:].reshape(len(x), 2, self.hidden, len(self.senses) + 2)
        sign = np.array([-1.0 if mirror and s in MIRRORED else 1.0 for s in self.senses])
        felt = neurons[..., :-2] * sign / np.array([TYPICAL[sense] for sense in self.senses])
        limits = np.array([SHIFT_M, LIFT_M])[:, None]
        output = limits * neurons[..., -1]
        total = np.abs(output).sum(axis=-1, keepdims=True)
        output = output * np.minimum(1.0, limits / np.maximum(total, 1e-9))
        weights = np.concatenate([felt, neurons[..., -2:-1], output[..., None]], axis=-1)
        return np.concatenate([sigma * np.exp(0.5 * x[:, :1]), weights.reshape(len(x), -1)], axis=1)

    def by_hand(self, gains: dict[str, np.ndarray]) -> np.ndarray:
        """Return vectors [lanes, size] of laws of one neuron per network, by their gains:

            shift = S tanh(Σ k s / S),    lift = H tanh(Σ k s / H),

        with S and H the most that is allowed. Hind legs are lifted by pitch the other way.

        Args:
            gains: k [lanes] by names such as `shift_pitch` and `lift_roll_rate`, l0 per unit.
        """
        lanes = len(next(iter(gains.values())))
        x = np.zeros((lanes, self.ends, 2, self.hidden, len(self.senses) + 2))
        for name, gain in gains.items():
            motion, _, sense = name.partition("_")
            network, limit = {"shift": (0, SHIFT_M), "lift": (1, LIFT_M)}[motion]
            for end in range(self.ends):
                turned = -1.0 if end and network and sense.startswith("pitch") else 1.0
                x[:, end, network, 0, self.senses.index(sense)] = (
                    turned * gain * TYPICAL[sense] / limit
                )
        x[:, :, :, 0, -1] = 1.0
        x = x.reshape(lanes, self.ends, -1)
        return np.concatenate([np.zeros((lanes, self.ends, 1)), x], axis=2).reshape(lanes, -1)

    def random(self, rng: np.random.Generator) -> np.ndarray:
        """Return a random start: networks that add little."""
        neurons = rng.normal(size=(self.ends, 2 * self.hidden, len(self.senses) + 2))
        neurons[..., -1] *= 0.1
        units = neurons.reshape(self.ends, -1)
        return np.concatenate([np.zeros((self.ends, 1)), units], axis=1).ravel()


@needing("x_m", "y_m", "work_absolute_j", "failed", "time_s")
def _around_loss(path: Any, scenario: Any, body: Any, timing: Timing) -> dict[str, Any]:
    """Return the speeds and costs in half of the time before and after the loss, and when it
    fell.
    """
    frames = path.x_m.shape[0]
    cut = round(LOST_S / timing.frame_s) - 1
    ends = (cut // 2, cut), (frames - 1 - (frames - cut) // 2, frames - 1)
    results = {}
    for name, (a, b) in zip(("before", "after"), ends, strict=True):
        distance = jnp.hypot(path.x_m[b] - path.x_m[a], path.y_m[b] - path.y_m[a])
        work = path.work_absolute_j[b] - path.work_absolute_j[a]
        results[name] = distance / ((b - a) * timing.frame_s)
        results[f"cost_{name}"] = work / jnp.maximum(distance, 0.01)
    fell = jnp.take_along_axis(path.time_s, jnp.argmax(path.failed, axis=0)[None], 0)[0]
    return {**results, "fell": jnp.where(path.failed[-1], fell, jnp.inf)}


WALKS = 0.3
"""Speed from which on a walker is not paid for more [√(g l0)]."""


def scores(
    legged: Legged, weights: np.ndarray, *, missing: tuple[int, ...], starts: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the scores of controllers without each leg, and the shares of their starts that walk
    on.

    A start that falls before the loss has t / T - 1 of that time. One that stands has 0 to 1 by
    the logarithm of the time until it falls afterwards; if it does not, up to half for its speed
    and 0.5 / (1 + CoT) besides. 0.3 / (1 + CoT) is for the walk before, all times its speed, as
    far as that is below 0.3.

    Args:
        legged: the system.
        weights: [controllers, n_weights].
        missing: legs, each lost by itself.
        starts: releases of each.
        seed: of their phases.

    Returns:
        scores and shares, [controllers, missing] each.
    """
    limbs, controllers = legged.body.limbs, len(weights)
    leg = np.tile(np.repeat(missing, starts), controllers)
    presence = np.array([(leg != k).astype(float) for k in range(limbs)])
    phase = np.tile(random_phases(limbs, starts, seed), (1, len(missing) * controllers))
    changes = {"present": Step(presence, from_s=LOST_S)}
    scenario = with_changes(legged.scenario(phase), legged.body, changes)
    lanes = np.repeat(weights, len(missing) * starts, axis=0)
    results = legged.rollout(_around_loss, TIMING).run(lanes, scenario, legged.body)
    f = {n: np.asarray(x, float).reshape(controllers, -1, starts) for n, x in results.items()}
    time_after_loss = np.clip(f["fell"] - LOST_S, 0.0, TIMING.duration_s - LOST_S)
    stays = np.isinf(f["fell"])
    score = np.log1p(time_after_loss) / np.log1p(TIMING.duration_s - LOST_S)
    paid = 0.5 * np.minimum(f["after"] / WALKS, 1.0) + 0.5 / (1.0 + f["cost_after"])
    score = score + np.where(stays, paid, 0.0) + 0.3 / (1.0 + f["cost_before"])
    score = score * np.clip(f["before"] / WALKS, 0.0, 1.0)
    score = np.where(f["fell"] > LOST_S, score, f["fell"] / LOST_S - 1.0)
    walks = stays & (f["after"] > 0.1)
    return score.mean(axis=2), walks.mean(axis=2)


def loss_of(score: np.ndarray) -> np.ndarray:
    """Return the loss that a search minimises: the worst leg counts most, [controllers]."""
    return -(score.min(axis=1) + 0.3 * score.mean(axis=1))
