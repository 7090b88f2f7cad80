"""All metrics of a gait at once, lane by lane: from simulated frames, or from any recording."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.bodies import Body
from tegotae.errors import TegotaeError, require_finite
from tegotae.metrics.efficiency import check_work, cot_inverse, work_total
from tegotae.metrics.hopping import dies_out, hops
from tegotae.metrics.limit_cycle import LimitCycle, settled
from tegotae.metrics.recording import from_samples
from tegotae.metrics.smoothness import FORCE_PERIOD_S, smoothness
from tegotae.metrics.spectrum import delta_omega, delta_w, peak, spectrum
from tegotae.rollout import Scenario, Timing, Trajectory

FAILED, AT_REST, UNSETTLED, LIMIT_CYCLE = range(4)
REGIMES = ("failed", "at rest", "no limit cycle", "limit cycle")
"""What a gait can be; `Gait.regime` is an index into it."""


class Gait(NamedTuple):
    """The paper's metrics of a gait (IV-A): arrays of shape [lanes], NaN where undefined."""

    regime: Any
    """Index into `REGIMES`."""
    limit_cycle_period: Any
    """Period k of the limit cycle [hops]."""
    cot_inverse: Any
    """CoT⁻¹ A, of the heights climbed in flight [m/J], over the settled part (equation 12).
    Zero for a body at rest or one that does no work."""
    cot_inverse_total: Any
    """CoT⁻¹ B, of all heights climbed [m/J]."""
    t0_s: Any
    """T0, time from release until settled [s]."""
    t1_s: Any
    """T1, time from the first touchdown after the disturbance until settled again [s]."""
    w_peak: Any
    """Frequency of the highest peak of the height's spectrum over the settled part [rad/s]."""
    a_peak: Any
    """Square root of that peak's share of the power."""
    delta_omega: Any
    """ΔΩ (equation 13)."""
    delta_w: Any
    """Δw (equation 14) [rad/s]."""
    smoothness: Any
    """Root-mean-square rate of change of the actuator force over α, settled part [1/s]."""
    hop_rate: Any
    """Hop frequency, 2π times hops over time, over the whole cycles of CoT⁻¹ [rad/s]."""


@partial(jax.jit, static_argnames=("frame_s", "undisturbed_s", "limit_cycle", "work"))
def gait(
    trajectory: Trajectory,
    *,
    omega: Any,
    rest_length_m: Any,
    max_force_n: Any,
    frame_s: float,
    undisturbed_s: float | None = None,
    disturbed_at_s: Any = None,
    limit_cycle: LimitCycle = LimitCycle(),  # noqa: B008 - immutable
    work: str = "absolute",
) -> Gait:
    """The metrics of every lane's gait.

    All but T1 are measured in the undisturbed window, from the release to `undisturbed_s`, and
    there on the settled part: from the first settled apex to the window's end. CoT⁻¹ is taken over
    its last whole cycles, from apex to apex. T1 needs a gait that was settled before the
    disturbance and settles again before the trajectory's end.

    Args:
        trajectory: frames of shape [frames, lanes], from the release on.
        omega: prescribed frequency ω [rad/s], one or [lanes]; NaN if there is none.
        rest_length_m: rest length of the leg l0 [m].
        max_force_n: largest actuator force α [N].
        frame_s: recording period [s].
        undisturbed_s: end of the undisturbed window [s]; the whole trajectory if None.
        disturbed_at_s: time of the disturbance [s], not before `undisturbed_s`, one or [lanes];
            None if there is none, infinite in lanes without.
        limit_cycle: what counts as settled.
        work: definition of work, one of `WORK`.

    Raises:
        TegotaeError: for an unknown definition of work, or a recording period of which 20 ms is no
            multiple (`smoothness`).
    """
    table = hops(trajectory, rest_length_m)
    whole = trajectory
    if undisturbed_s is not None:
        frames = int(undisturbed_s / frame_s + 1e-6)
        if not 4 <= frames <= len(whole.time_s):
            raise TegotaeError(
                f"undisturbed_s is {undisturbed_s:g}; it must be at least four frames "
                f"({4 * frame_s:g} s) and within the trajectory ({len(whole.time_s) * frame_s:g} s)"
            )
        trajectory = jax.tree.map(lambda recorded: recorded[:frames], whole)
    end_s = trajectory.time_s[-1]
    cycle = settled(table, limit_cycle, -jnp.inf, end_s)
    failed = trajectory.failed[-1]
    found = cycle.found & ~failed
    last_hop_s = jnp.max(jnp.where(table.time_s <= end_s[None], table.time_s, -jnp.inf), axis=0)
    rests = dies_out(last_hop_s, end_s)
    regime = jnp.where(
        failed, FAILED, jnp.where(found, LIMIT_CYCLE, jnp.where(rests, AT_REST, UNSETTLED))
    )

    def where_settled(value: Any) -> Any:
        return jnp.where(found, value, jnp.nan)

    def over_cycles(total: Any) -> Any:
        def at(hop: Any) -> Any:
            frame = jnp.take_along_axis(table.frame, hop[None], axis=0)
            return jnp.take_along_axis(total, frame, axis=0)[0]

        return at(cycle.to_hop) - at(cycle.from_hop)

    done = over_cycles(work_total(whole, work))

    def efficiency(climb: Any) -> Any:
        # Negative work (and work that was not recorded) has no efficiency.
        value = jnp.where(done > -1e-6, cot_inverse(over_cycles(climb), done), jnp.nan)
        return jnp.where(regime == AT_REST, 0.0, where_settled(value))

    def apex_s(hop: Any) -> Any:
        return jnp.take_along_axis(table.time_s, hop[None], axis=0)[0]

    cycles_s = apex_s(cycle.to_hop) - apex_s(cycle.from_hop)
    hops_s = cycles_s / (cycle.to_hop - cycle.from_hop).astype(cycles_s.dtype)
    start_s = jnp.where(found, cycle.time_s, 0.0)
    first = jnp.floor(start_s / frame_s).astype(jnp.int32)
    power = spectrum(trajectory.height_m, frame_s, first)
    w_peak, a_peak = peak(power)
    t1_s = jnp.full_like(cycle.time_s, jnp.nan)
    if disturbed_at_s is not None:
        touchdowns = jnp.asarray(whole.touchdown_time_s)
        after = touchdowns > jnp.asarray(disturbed_at_s, touchdowns.dtype).reshape(1, -1)
        touchdown = jnp.min(jnp.where(after, touchdowns, jnp.inf), axis=0)
        again = settled(table, limit_cycle, touchdown, whole.time_s[-1])
        t1_s = where_settled(jnp.where(whole.failed[-1], jnp.nan, again.time_s - touchdown))
    return Gait(
        regime=regime,
        limit_cycle_period=where_settled(cycle.period),
        cot_inverse=efficiency(whole.climb_flight_m),
        cot_inverse_total=efficiency(whole.climb_m),
        t0_s=where_settled(cycle.time_s),
        t1_s=t1_s,
        w_peak=where_settled(w_peak),
        a_peak=where_settled(a_peak),
        delta_omega=where_settled(delta_omega(omega, w_peak, a_peak)),
        delta_w=where_settled(delta_w(power, omega)),
        smoothness=where_settled(smoothness(trajectory.impulse_ns, max_force_n, frame_s, start_s)),
        hop_rate=where_settled(2.0 * jnp.pi / hops_s),
    )


@dataclass(frozen=True, kw_only=True)
class GaitSummary:
    """The metrics of a rollout's gait, as an `Engine`'s summary: `Gait` of arrays [lanes].

    Args:
        undisturbed_s: end of the undisturbed window [s]; the whole rollout if None.
        limit_cycle: what counts as settled.
        work: definition of work, one of "absolute", "positive", "net".

    Example:
        >>> import numpy as np
        >>> from tegotae import Engine, Scenario, build
        >>> engine = Engine(controller=build("V-reflex-w8"), summary=GaitSummary())
        >>> found = engine.run(np.array([[2.0]]), Scenario(omega=8.0))
        >>> f"{found.limit_cycle_period[0]:.0f} {found.cot_inverse[0]:.2f} m/J"
        '1 0.43 m/J'
    """

    undisturbed_s: float | None = None
    limit_cycle: LimitCycle = field(default_factory=LimitCycle)
    work: str = "absolute"

    def __post_init__(self) -> None:
        check_work(self.work)
        if self.undisturbed_s is not None:
            require_finite("undisturbed_s", self.undisturbed_s, above=0.0)

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
            undisturbed_s=self.undisturbed_s,
            disturbed_at_s=scenario.drop_time_s,
            limit_cycle=self.limit_cycle,
            work=self.work,
        )


def measure(
    time_s: Any,
    height_m: Any,
    *,
    rest_length_m: float,
    ground_m: Any = 0.0,
    phase_rad: Any = None,
    omega: float | None = None,
    force_n: Any = None,
    max_force_n: float | None = None,
    disturbed_at_s: float | None = None,
    limit_cycle: LimitCycle | None = None,
    work: str = "absolute",
) -> Gait:
    """The metrics of one recorded gait, from a robot or another simulator.

    The first sample is the release. What is missing leaves undefined (NaN) what needs it: the force
    CoT⁻¹ and smoothness, the largest force smoothness, the prescribed frequency ΔΩ and Δw, the
    disturbance T1. A recording without any hop is no error: `regime` says so, CoT⁻¹ is zero and all
    else undefined. Work that is negative in sum leaves CoT⁻¹ undefined.

    Args:
        time_s: sampling times, uniform, at most 20 ms apart [s], shape [samples].
        height_m: height of the centre of mass y [m], [samples].
        rest_length_m: height over ground at which the foot leaves it, l0 [m].
        ground_m: height of the ground h [m], a number or [samples].
        phase_rad: oscillator phase φ [rad], [samples]; None without an oscillator.
        omega: prescribed frequency ω [rad/s].
        force_n: actuator force F_a [N], [samples].
        max_force_n: largest actuator force α [N].
        disturbed_at_s: when a disturbance, such as a drop of the ground, took place [s].
        limit_cycle: what counts as settled; its tolerances are for a leg of 1 m.
        work: definition of work, one of "absolute", "positive", "net".

    Returns:
        A `Gait` of floats.

    Raises:
        TegotaeError: for a recording that `from_samples` refuses, or a disturbance outside of it.

    Example:
        >>> import numpy as np
        >>> time_s = np.arange(4000) * 0.005
        >>> found = measure(time_s, 1 + 0.1 * np.sin(6 * time_s), rest_length_m=1.0, omega=6.0)
        >>> REGIMES[found.regime], f"{found.w_peak:.2f} rad/s"
        ('limit cycle', '6.00 rad/s')
    """
    if omega is not None:
        require_finite("omega", omega)
    if max_force_n is not None:
        require_finite("max_force_n", max_force_n, above=0.0)
    check_work(work)
    frames = from_samples(
        time_s,
        height_m,
        rest_length_m=rest_length_m,
        ground_m=ground_m,
        phase_rad=phase_rad,
        force_n=force_n,
        frame_s=FORCE_PERIOD_S,
    )
    undisturbed_s = None
    if disturbed_at_s is not None:
        require_finite("disturbed_at_s", disturbed_at_s)
        disturbed_at_s -= float(np.asarray(time_s)[0])
        duration_s = float(frames.time_s[-1, 0])
        if not 4 * FORCE_PERIOD_S <= disturbed_at_s <= duration_s:
            raise TegotaeError(
                f"disturbed_at_s lies {disturbed_at_s:g} s after the first sample; it must lie "
                f"inside the recording of {duration_s:g} s, and at least four frames "
                f"({4 * FORCE_PERIOD_S:g} s) after its start"
            )
        undisturbed_s = disturbed_at_s
    with jax.enable_x64(True):
        found = gait(
            frames,
            omega=np.nan if omega is None else float(omega),
            rest_length_m=float(rest_length_m),
            max_force_n=np.nan if max_force_n is None else float(max_force_n),
            frame_s=FORCE_PERIOD_S,
            undisturbed_s=undisturbed_s,
            disturbed_at_s=disturbed_at_s,
            limit_cycle=limit_cycle or LimitCycle(),
            work=work,
        )
        return Gait(*(np.asarray(value)[0].item() for value in found))
