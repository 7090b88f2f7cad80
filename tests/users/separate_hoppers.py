"""A user's body of several limbs: hoppers side by side that share nothing but their release."""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.parts.bodies import (
    Body,
    Contact,
    Hopper,
    HopperState,
    Push,
    Sensation,
)
from tegotae.parts.channels import State
from tegotae.parts.parameters import STATIC, traceable


@traceable
@dataclass(frozen=True, kw_only=True)
class SeparateHoppers(Body):
    """Some hoppers; height and velocity are their means, an apex is one of the first's."""

    SENSES = Hopper.SENSES

    hopper: Hopper = field(default_factory=Hopper)
    hoppers: int = field(default=2, metadata=STATIC)

    @property
    def max_force_n(self):
        return self.hopper.max_force_n

    @property
    def rest_length_m(self):
        return self.hopper.rest_length_m

    @property
    def limbs(self) -> int:
        return self.hoppers

    @property
    def rate_scale(self) -> jax.Array:
        return self.hopper.rate_scale

    @property
    def channels(self):
        return (State("hoppers_m", "Height of each [m].", lambda f: f.lane.moment.body.height),)

    def release(self, height_m, velocity_m_per_s, apart_m=0.0) -> HopperState:
        places = np.linspace(-0.5, 0.5, self.hoppers)
        return HopperState(
            jnp.stack([height_m + place * apart_m for place in places]),
            jnp.stack([velocity_m_per_s] * self.hoppers),
        )

    def _ground(self, state: HopperState, ground_m) -> jax.Array:
        return jnp.broadcast_to(ground_m, state.height.shape)

    def sense(self, state, ground_m) -> Sensation:
        return self.hopper.sense(state, self._ground(state, ground_m))

    def predict(self, state, force_n, ground_m, tick_s):
        return self.hopper.predict(state, force_n, self._ground(state, ground_m), tick_s)

    def advance(self, state, push: Push, ground_m, tick_s):
        end, contact = self.hopper.advance(state, push, self._ground(state, ground_m), tick_s)
        of_body = {
            "climb_flight_m": contact.climb_flight_m.mean(axis=0),
            "climb_m": contact.climb_m.mean(axis=0),
            "apex_share": contact.apex_share[0],
            "apex_height_m": contact.apex_height_m[0],
        }
        return end, Contact(**{**contact._asdict(), **of_body})

    def failed(self, state, ground_m):
        return self.hopper.failed(state, self._ground(state, ground_m)).any(axis=0)

    def height(self, state):
        return state.height.mean(axis=0)

    def velocity(self, state):
        return state.velocity.mean(axis=0)

    def energy(self, state, ground_m):
        return self.hopper.energy(state, self._ground(state, ground_m)).sum(axis=0)
