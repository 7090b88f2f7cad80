"""All metrics of a gait at once, lane by lane."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.measures.hopping.hopping import LimitCycle, hops, settled
from tegotae.measures.hopping.metric import REGIME, Episode, GaitMetric
from tegotae.measures.hopping.registry import built_in_gait, channels_of
from tegotae.parts._shapes import Numeric
from tegotae.parts.bodies import Body
from tegotae.simulation.rollout import Scenario, Timing, Trajectory


@jax.tree_util.register_pytree_node_class
@dataclass(frozen=True, eq=False, repr=False)
class Gait:
    """The metrics of a gait, by name: `gait.t0_s`. Arrays of shape [lanes], NaN where undefined.

    There is every `GaitMetric` that was asked for, and `regime`, the index into `REGIMES`.

    Args:
        values: by name.

    Example:
        >>> Gait({"t0_s": 3.5}).t0_s
        3.5
    """

    values: Mapping[str, Any]

    def __getattr__(self, name: str) -> Any:
        # Before the values are there, as in a copy being made, nothing is.
        if name != "values" and name in self.values:
            return self.values[name]
        raise AttributeError(f"there is no metric {name!r} in this gait")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.values]

    def __repr__(self) -> str:
        return f"Gait({', '.join(f'{name}={value!r}' for name, value in self.values.items())})"

    def lane(self, number: int = 0) -> Gait:
        """The same of one lane, as Python's numbers."""
        return Gait({name: np.asarray(v)[number].item() for name, v in self.values.items()})

    def tree_flatten(self) -> tuple[tuple[Numeric, ...], tuple[str, ...]]:
        """For JAX: arrays, and their names."""
        return tuple(self.values.values()), tuple(self.values)

    @classmethod
    def tree_unflatten(cls, names: tuple[str, ...], arrays: Iterable[Numeric]) -> Gait:
        """The reverse."""
        return cls(dict(zip(names, arrays, strict=True)))


@partial(
    jax.jit,
    static_argnames=(
        *("frame_s", "undisturbed_s", "limit_cycle"),
        *("work", "has_oscillator", "metrics"),
    ),
)
def gait(
    trajectory: Trajectory,
    *,
    omega: Numeric,
    rest_length_m: Numeric,
    max_force_n: Numeric,
    frame_s: float,
    undisturbed_s: float | None = None,
    disturbed_at_s: Numeric | None = None,
    limit_cycle: LimitCycle = LimitCycle(),  # noqa: B008 - immutable
    work: str = "absolute",
    has_oscillator: bool = True,
    metrics: tuple[GaitMetric, ...] | None = None,
) -> Gait:
    """The metrics of every lane's gait.

    All but T1 are measured in the undisturbed window, from the release to `undisturbed_s`, and
    there on the settled part: from the first settled apex to the window's end. CoT⁻¹ is taken over
    its last whole cycles, from apex to apex. T1 needs a gait that was settled before the
    disturbance and settles again before the trajectory's end.

    Args:
        trajectory: frames of shape [frames, lanes], from the release on.
        omega: prescribed frequency ω [rad/s], one or [lanes]; NaN if it is not known.
        rest_length_m: rest length of the leg l0 [m].
        max_force_n: largest actuator force α [N].
        frame_s: recording period [s].
        undisturbed_s: end of the undisturbed window [s]; the whole trajectory if None.
        disturbed_at_s: time of the disturbance [s], not before `undisturbed_s`, one or [lanes];
            None if there is none, infinite in lanes without.
        limit_cycle: what counts as settled.
        work: definition of work, one of `WORK`.
        has_oscillator: False if no frequency is prescribed at all; ΔΩ is then zero.
        metrics: which; the package's own by default.

    Raises:
        TegotaeError: for an unknown definition of work, or a recording period of which 20 ms is no
            multiple (`smoothness`).
    """
    table, undisturbed = hops(trajectory, rest_length_m), trajectory
    if undisturbed_s is not None:
        frames = int(undisturbed_s / frame_s + 1e-6)
        undisturbed = jax.tree.map(lambda recorded: recorded[:frames], trajectory)
    episode = Episode(
        trajectory=undisturbed,
        whole=trajectory,
        hops=table,
        cycle=settled(table, limit_cycle, -jnp.inf, undisturbed.time_s[-1]),
        omega=omega,
        has_oscillator=has_oscillator,
        rest_length_m=rest_length_m,
        max_force_n=max_force_n,
        frame_s=frame_s,
        disturbed_at_s=disturbed_at_s,
        limit_cycle=limit_cycle,
        work=work,
    )
    chosen = built_in_gait() if metrics is None else metrics
    return Gait({REGIME: episode.regime} | {m.name: m.compute(episode) for m in chosen})


@dataclass(frozen=True, kw_only=True)
class GaitSummary:
    """The metrics of a rollout's gait, as an `Engine`'s summary: `Gait` of arrays [lanes].

    Args:
        work: definition of work, one of "absolute", "positive", "net".

    Example:
        >>> import numpy as np
        >>> from tegotae import Engine, Scenario, build
        >>> engine = Engine(controller=build("V-reflex-w8"), summary=GaitSummary())
        >>> path = engine.run(np.array([[2.0]]), Scenario(omega=8.0))
        >>> f"{path.limit_cycle_period[0]:.0f} {path.cot_inverse[0]:.2f} m/J"
        '1 0.43 m/J'
    """

    work: str = "absolute"

    @property
    def needs(self) -> tuple[str, ...]:
        """The channels that are recorded for it."""
        return channels_of(built_in_gait())

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Gait:
        """The metrics, each of shape [lanes]."""
        return gait(
            trajectory,
            omega=scenario.omega,
            rest_length_m=body.rest_length_m,
            max_force_n=body.max_force_n,
            frame_s=timing.frame_s,
            disturbed_at_s=scenario.drop_time_s,
            work=self.work,
        )
