"""Explain a controller in numbers: the curves of its terms over the settled gait, the phases at
which it waits and pushes, its score without feedback, and its response to the command."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.measures.evaluation import EvaluatedEpisodes, Protocol
from tegotae.measures.hopping.metrics import LIMIT_CYCLE, REGIME, cot_inverse, hop_rate
from tegotae.measures.statistics import (
    POSITIVE,
    Interval,
    interval,
    mean_defined,
    paired_difference,
)
from tegotae.parts.controller import Controller
from tegotae.parts.held import with_held_feedback
from tegotae.parts.maths import TWO_PI
from tegotae.parts.terms import Signals
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.simulation.summaries import KeptChannels
from tegotae.systems.controller_file import SavedController
from tegotae.systems.legged import Legged, lanes_of

SPREAD_M = 0.1
"""Largest height of a release of one leg above or below the default one [m]."""
NOTHING = 0.01
"""A score below which a controller does not get anywhere."""
ALIKE = 0.95
"""A share of the score from which on it is the same."""
PARKED = 0.1
"""A phase that moves slower than this share of ω waits."""
_BINS = 120
"""Parts of a turn in which phases are counted."""
EPISODE = ("merit", "rate_rad_per_s", "sound", "speed_m_per_s")
"""Numbers of an episode (`Evaluated`)."""
_CHANNELS = ("phase_rad", "spring_force_n", "velocity_m_per_s", "feedback_rad_per_s")


@dataclass(frozen=True)
class Evaluated:
    """Scores of a controller from several releases at several frequencies.

    Args:
        omega: commanded ω [rad/s], shape [frequencies]; NaN without an oscillator.
        merit: CoT⁻¹, of one leg [m/J], of several without a unit; 0 of what does not settle, or
            falls. Shape [releases, frequencies].
        rate_rad_per_s: hops, or turns of the reference leg, likewise; NaN where undefined.
        sound: whether it settles on a limit cycle, or stays up, likewise.
        speed_m_per_s: of a walk, likewise; NaN of one leg.
    """

    omega: np.ndarray
    merit: np.ndarray
    rate_rad_per_s: np.ndarray
    sound: np.ndarray
    speed_m_per_s: np.ndarray

    @property
    def mean(self) -> Interval:
        """The merit: the mean over frequencies, and over releases with its 95 % interval."""
        return interval(self.merit.mean(axis=1), within=POSITIVE)

    def over(self, baseline: Evaluated, share: float = 1.0) -> Interval:
        """Return the difference to a share of a baseline's merit, release by release, with its
        interval.

        Args:
            baseline: evaluated from the same releases.
            share: of its merit.
        """
        ours, theirs = self.merit.mean(axis=1), share * baseline.merit.mean(axis=1)
        return paired_difference(ours, theirs, within=POSITIVE)

    def of_releases(self, releases: slice) -> Evaluated:
        """Return the part that belongs to some of the releases."""
        return Evaluated(self.omega, *(getattr(self, name)[releases] for name in EPISODE))

    @property
    def rates(self) -> np.ndarray:
        """Mean rate at every frequency [rad/s], [frequencies]."""
        return mean_defined(self.rate_rad_per_s.T)

    @property
    def following(self) -> float:
        """Slope of the rate over ω, fitted to all releases together: 1 follows the command, 0
        ignores it; NaN where undefined."""
        omega = np.broadcast_to(self.omega, self.merit.shape)
        valid = self.sound & np.isfinite(self.rate_rad_per_s) & np.isfinite(omega)
        if len(np.unique(omega[valid])) < 2:
            return math.nan
        return float(np.polyfit(omega[valid], self.rate_rad_per_s[valid], 1)[0])

    @property
    def following_of_releases(self) -> Interval:
        """Slope of `following` for each release alone: mean and 95 % interval."""
        releases = [slice(i, i + 1) for i in range(len(self.merit))]
        return interval([self.of_releases(release).following for release in releases])


@dataclass(frozen=True)
class ReleasedController(ABC):
    """Releases of a controller, the same ones at every frequency.

    Args:
        saved: the system and the weights of the whole controller.
        omega: commanded ω [rad/s], shape [frequencies]; NaN without an oscillator.
        release: entries of shape [releases] or, of phases a leg, [limbs, releases].
        timing: of an episode.
    """

    saved: SavedController
    omega: np.ndarray
    release: Scenario
    timing: Timing

    @property
    def shape(self) -> tuple[int, int]:
        """Releases, frequencies."""
        return np.shape(self.release.phase_rad)[-1], len(self.omega)

    @property
    def middle(self) -> int:
        """Index of the frequency of the training."""
        omega = self.saved.omega
        return 0 if omega is None else int(np.argmin(np.abs(self.omega - omega)))

    @property
    def scenario(self) -> Scenario:
        """A lane for each frequency of each release."""
        releases, n = self.shape
        entries = {"phase_rad": np.repeat(self.release.phase_rad, n, axis=-1)}
        if np.ndim(self.release.height_m):
            entries["height_m"] = np.repeat(self.release.height_m, n)
        return self.release._replace(omega=np.tile(np.nan_to_num(self.omega), releases), **entries)

    def lanes(self, weights: np.ndarray) -> np.ndarray:
        """Return the weights of every lane, from those of a controller, [n] or [frequencies, n]."""
        of_lanes = np.broadcast_to(weights, (*self.shape, np.shape(weights)[-1]))
        return of_lanes.reshape(-1, of_lanes.shape[-1])

    @abstractmethod
    def evaluated(self, controller: Controller, weights: np.ndarray) -> Evaluated:
        """Evaluate a controller from all releases at all frequencies.

        Args:
            controller: in place of the whole one.
            weights: the same at every frequency, [n_weights], or [frequencies, n_weights].
        """

    def recorded(self) -> dict[str, np.ndarray]:
        """Return the second halves of the whole controller's episodes, [frames, limbs, releases,
        frequencies].

        Beside its channels there is `rate_rad_per_s`, the mean of φ̇ over a frame. Its turns are
        counted tick by tick: in a frame a fast phase passes more than half a turn.
        """
        system = self.saved.system
        rollout = system.rollout(KeptChannels((*_CHANNELS, "actuator_force_n")), self.timing)
        path = rollout.run(self.lanes(self.saved.weights), self.scenario, system.mechanics)
        arrays = {name: np.asarray(value, float) for name, value in path.channels.items()}
        frame_s, whole_s = self.timing.frame_s, self.timing.n_frames * self.timing.frame_s
        every_tick = replace(self.timing, duration_s=whole_s, frame_s=self.timing.tick_s)
        ticks = system.rollout(KeptChannels(("phase_rad",)), every_tick)
        phase = ticks.run(self.lanes(self.saved.weights), self.scenario, system.mechanics).phase_rad
        turned = np.diff(phase, axis=0, prepend=phase[:1])
        turned = (turned + np.pi) % TWO_PI - np.pi
        turned = turned.reshape(-1, self.timing.ticks_per_frame, *turned.shape[1:]).sum(axis=1)
        arrays["rate_rad_per_s"] = turned / frame_s
        half = len(turned) // 2
        limbs = arrays["phase_rad"].shape[1:-1] or (1,)

        def of_limbs(x: np.ndarray) -> np.ndarray:
            x = x if x.ndim == 3 else x[:, None]
            x = np.broadcast_to(x, (len(x), *limbs, x.shape[-1]))
            return x.reshape(*x.shape[:2], *self.shape)[half:]

        return {name: of_limbs(x) for name, x in arrays.items()}


@dataclass(frozen=True)
class ReleasedHopper(ReleasedController):
    """Releases of a controller on one leg.

    Args:
        protocol: what counts as settled, and the definition of work.
    """

    protocol: Protocol = field(default_factory=Protocol)

    def evaluated(self, controller: Controller, weights: np.ndarray) -> Evaluated:
        system = self.saved.system
        omega = np.tile(self.omega, self.shape[0])
        if controller.oscillator is None:
            omega = np.full_like(omega, np.nan)
        episodes = EvaluatedEpisodes(
            controller,
            self.lanes(weights),
            self.scenario._replace(omega=omega),
            system.mechanics,
            self.protocol,
            system.integrator,
        )
        values, _ = episodes.measured((cot_inverse, hop_rate), ())
        results = {name: np.reshape(x, self.shape) for name, x in values.items()}
        merit, rate = np.nan_to_num(results["cot_inverse"]), results["hop_rate"]
        return Evaluated(
            self.omega, merit, rate, results[REGIME] == LIMIT_CYCLE, np.full_like(rate, np.nan)
        )


@dataclass(frozen=True, kw_only=True)
class ReleasedWalker(ReleasedController):
    """Releases of a controller on several legs.

    Args:
        legged: their system.
    """

    legged: Legged

    def evaluated(self, controller: Controller, weights: np.ndarray) -> Evaluated:
        system = replace(self.saved.system, controller=controller)
        rollout = system.rollout(self.legged.summary(), self.timing)
        results = lanes_of(rollout.run(self.lanes(weights), self.scenario, system.mechanics))
        cost, speed, hz, fall = (
            np.reshape(getattr(results, name), self.shape)
            for name in ("cost_of_transport", "speed_m_per_s", "cycle_frequency_hz", "fall_time_s")
        )
        sound = ~np.isfinite(fall)
        with np.errstate(divide="ignore", invalid="ignore"):
            merit = np.where(sound & (cost > 0.0), 1.0 / cost, 0.0)
        return Evaluated(self.omega, merit, np.where(sound, TWO_PI * hz, np.nan), sound, speed)


def without_feedback(released: ReleasedController, feedback: np.ndarray) -> dict[str, Evaluated]:
    """Evaluate a controller with its feedback cut, and frozen at its mean over the gait.

    The result is {} for a controller without feedback.

    Args:
        released: from which releases.
        feedback: f [rad/s] of the whole controller, [frequencies]; 0 where it never settles.
    """
    saved = released.saved
    if saved.controller.tegotae is None:
        return {}
    weights = np.broadcast_to(saved.weights, (len(feedback), len(saved.weights)))
    return {
        name: released.evaluated(*with_held_feedback(saved.controller, weights, f))
        for name, f in (("cut", 0.0), ("frozen", feedback))
    }


@dataclass(frozen=True)
class Visits:
    """Moments of settled gaits at the frequency of the training, of units with the same weights.

    Arrays of shape [moments], evenly spaced in time.
    """

    phase_rad: np.ndarray
    """Phase φ in [0, 2π)."""
    spring_force_n: np.ndarray
    """Spring force F_k [N]."""
    load: np.ndarray
    """The same in weights of the body, N."""
    rate_rad_per_s: np.ndarray
    """φ̇ [rad/s]."""
    feedback_rad_per_s: np.ndarray
    """f [rad/s]."""
    actuator_force_n: np.ndarray
    """Actuator force [N]."""
    action: np.ndarray
    """A′(φ); NaN where it is not known."""
    reaction: np.ndarray
    """R(s), likewise."""
    gain: np.ndarray
    """G, likewise."""

    @property
    def stance(self) -> np.ndarray:
        """True where the leg is loaded."""
        return self.load > 0.0


def visits(
    released: ReleasedController, evaluated: Evaluated, recorded: dict[str, np.ndarray]
) -> list[Visits]:
    """Return the samples of settled gaits, set of weights by set; those of all releases where none
    settles.

    Args:
        released: from which releases.
        evaluated: of the controller.
        recorded: its second halves (`ReleasedController.recorded`).
    """
    controller, index = released.saved.controller, released.middle
    sound = evaluated.sound[:, index]
    sound = sound if sound.any() else np.ones_like(sound)
    sharing = np.array(controller.sharing or (0,) * controller.limbs)

    def of_set(number: int) -> Visits:
        moments = {
            name: x[:, sharing == number][:, :, sound, index].ravel()
            for name, x in recorded.items()
        }
        load, terms = _terms(released.saved, moments, number)
        del moments["velocity_m_per_s"]
        return Visits(**moments, load=load, **terms)

    return [of_set(number) for number in range(controller.sets)]


def _terms(
    saved: SavedController, moments: dict[str, np.ndarray], number: int
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the load and the values of the feedback's terms at some moments, [moments] each."""
    controller, body = saved.controller, saved.body
    none = np.full_like(moments["phase_rad"], np.nan)
    with jax.enable_x64(True):
        state = body.release(jnp.full(1, saved.system.release.height_m), jnp.zeros(1))
        scales = dict(body.sense(state, jnp.zeros(1)).scales)
        values = {
            "spring_force": jnp.asarray(moments["spring_force_n"]),
            "velocity": jnp.asarray(moments["velocity_m_per_s"]),
        }
        oscillator = controller.oscillator
        if oscillator is not None and oscillator.has_phase:
            values |= oscillator.signals(oscillator.start(jnp.asarray(moments["phase_rad"])))
        load = np.asarray(Signals(values, scales).dimensionless("spring_force"), float)
        unit = np.asarray(saved.weights, float)[number * controller.unit_weights :]
        results: dict[str, np.ndarray] = dict.fromkeys(("action", "reaction", "gain"), none)
        for role, term in controller.terms.items():
            if role in results and {*term.reads} <= {*values}:
                columns = [jnp.full(len(none), x) for x in unit[controller.layout[role]]]
                results[role] = np.broadcast_to(term(columns, Signals(values, scales)), none.shape)
    return load, results


def mean_feedback(evaluated: Evaluated, recorded: dict[str, np.ndarray]) -> np.ndarray:
    """Return f over settled gaits at every frequency [rad/s], [frequencies]; 0 if none settles."""
    feedback = recorded["feedback_rad_per_s"].mean(axis=(0, 1))
    sound = evaluated.sound.sum(axis=0)
    return np.where(evaluated.sound, feedback, 0.0).sum(axis=0) / np.maximum(sound, 1)


# Curves as formulas, by least squares: moments are even in time, so each visit counts.


@dataclass(frozen=True)
class Fit:
    """A formula of a curve.

    Args:
        formula: with its numbers.
        numbers: the coefficients of its columns, and a number inside of these, if there is one.
        explained: R², the share of the curve's variance over the visits; NaN of a constant.
    """

    formula: str
    numbers: tuple[float, ...]
    explained: float


def signed(x: float, digits: int = 3) -> str:
    """Return a number as a summand, its sign set apart.

    Example:
        >>> signed(-0.25), signed(2.0)
        ('- 0.25', '+ 2')
    """
    return f"{'-' if x < 0.0 else '+'} {abs(x):.{digits}g}"


def _least_squares(columns: list[np.ndarray], values: np.ndarray) -> tuple[list[float], float]:
    design = np.stack(columns, axis=1)
    numbers, *_ = np.linalg.lstsq(design, values, rcond=None)
    residual, all_of_it = np.mean((values - design @ numbers) ** 2), np.var(values)
    numbers[np.abs(numbers) < 1e-9 * np.abs(numbers).max(initial=0.0)] = 0.0  # rounding
    constant = np.ptp(values) <= 1e-6 * np.abs(values).max(initial=0.0)
    return numbers.tolist(), math.nan if constant else float(1.0 - residual / all_of_it)


def action_fits(v: Visits) -> list[Fit]:
    """Return A′ as an offset and one harmonic of the phase, and as an offset and two.

    Their numbers are o, a, b (, c, d) of `o + a cos φ + b sin φ (+ c cos 2φ + d sin 2φ)`.
    """
    phase = v.phase_rad
    columns = [np.ones_like(phase), np.cos(phase), np.sin(phase)]
    fits = []
    for basis in (columns, [*columns, np.cos(2.0 * phase), np.sin(2.0 * phase)]):
        numbers, explained = _least_squares(basis, v.action)
        parts = [f"{numbers[0]:.3g}"] if numbers[0] else []
        parts += [
            f"{math.hypot(a, b):.3g} cos({turns}φ - {math.atan2(b, a) % TWO_PI:.2f})"
            for turns, a, b in zip(("", "2"), numbers[1::2], numbers[2::2], strict=False)
            if a or b
        ]
        fits.append(Fit(" + ".join(parts) or "0", tuple(numbers), explained))
    return fits


_TRIED = [(0.0,), *((float(s),) for s in np.geomspace(0.05, 50.0, 61))]
"""Numbers s that are tried where a curve is not linear in them."""


def reaction_fits(v: Visits) -> dict[str, Fit]:
    """Return the reaction with its gain, G R, as formulas of the load N, each with the law that it
    belongs to.

    `b N`, `c + b N`, `c e^(-s N)` and `c + b N / (1 + s N)`.
    """
    values, load, ones = v.gain * v.reaction, v.load, np.ones_like(v.load)

    def fit(
        columns: Callable[..., list[np.ndarray]],
        formula: Callable[..., str],
        scales: Sequence[tuple[float, ...]] = ((),),
    ) -> Fit:
        tried = [(*_least_squares(columns(*s), values), s) for s in scales]
        linear, explained, s = max(tried, key=lambda x: np.nan_to_num(x[1], nan=-math.inf))
        return Fit(formula(*linear, *s), (*linear, *s), explained)

    return {
        "load": fit(lambda: [load], lambda b: f"{b:.3g} N"),
        "latch": fit(lambda: [ones, load], lambda c, b: f"{c:.3g} {signed(b)} N"),
        "decay": fit(
            lambda s: [np.exp(-s * load)],
            lambda c, s: f"{c:.3g} e^(-{s:.3g} N)",
            _TRIED,
        ),
        "saturating": fit(
            lambda s: [ones, load / (1.0 + s * load)],
            lambda c, b, s: f"{c:.3g} {signed(b)} N / (1 + {s:.3g} N)",
            _TRIED,
        ),
    }


@dataclass(frozen=True)
class Arc:
    """An interval of phases.

    Args:
        start_rad: angle at which it begins, in [0, 2π).
        width_rad: width.
        share: share of the selected moments that lie in it.
    """

    start_rad: float
    width_rad: float
    share: float


def arcs(phase_rad: np.ndarray, among: np.ndarray, inside: np.ndarray) -> list[Arc]:
    """Return the arcs of the circle where most moments are of a kind, the largest share first.

    Parts of a turn that are not visited belong to an interval if both neighbours do.

    Args:
        phase_rad: of moments, [moments].
        among: which of them count.
        inside: which of these are of the kind.

    Example:
        >>> phase = np.linspace(0.0, 6.28, 629)
        >>> (arc,) = arcs(phase, phase < 6.0, (phase > 1.0) & (phase < 2.0))
        >>> round(arc.start_rad, 1), round(arc.width_rad, 1), arc.share
        (1.0, 1.0, 1.0)
    """
    part = (phase_rad / TWO_PI * _BINS).astype(int) % _BINS
    all_of_it = np.bincount(part[among], minlength=_BINS)
    of_kind = np.bincount(part[among & inside], minlength=_BINS)
    bins = np.flatnonzero(all_of_it)
    mask = of_kind[bins] > 0.5 * all_of_it[bins]
    if not mask.any():
        return []
    if mask.all():
        return [Arc(0.0, TWO_PI, 1.0)]
    first = int(np.argmin(mask))  # begin outside
    bins, mask = np.roll(bins, -first), np.roll(mask, -first)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    width = TWO_PI / _BINS
    results = []
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        run = bins[begin:end]
        turn = (run[-1] - run[0]) % _BINS + 1
        results.append(Arc(run[0] * width, turn * width, of_kind[run].sum() / of_kind.sum()))
    return sorted(results, key=lambda arc: -arc.share)


def parking(v: Visits, omega: float) -> dict[str, tuple[float, list[Arc]]]:
    """Return, for flight and for stance, the share of the time in which the phase waits, and its
    arcs.

    Args:
        v: the visits.
        omega: commanded ω [rad/s].
    """
    waits = np.abs(v.rate_rad_per_s) < PARKED * omega
    places = {}
    for name, among in (("flight", ~v.stance), ("stance", v.stance)):
        share = float(np.mean(waits & among))
        places[name] = (share, arcs(v.phase_rad, among, waits) if share > 0.0 else [])
    return places


def pushing(v: Visits, most_n: float) -> tuple[float, list[Arc]]:
    """Return the share of the stance with more than half of the largest force, and where that is.

    Of an actuator that never reaches half of α it is half of the largest force that it has.

    Args:
        v: the visits.
        most_n: α [N].
    """
    half = 0.5 * min(most_n, max(float(v.actuator_force_n.max()), 1e-9))
    pushes = v.stance & (v.actuator_force_n > half)
    if not pushes.any():
        return 0.0, []
    return float(pushes.sum() / v.stance.sum()), arcs(v.phase_rad, v.stance, pushes)
