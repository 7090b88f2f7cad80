"""Certificates: sets of landings from which a hopper provably hops for ever, under a sampled law.

`research/certificate/page.md` has the theorem. The certificate proves nothing by itself: a checker
of its own computes every bound again with outward rounding.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import numpy as np

from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Hopper
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms.actuation import FreeSector, LearnedActuation, Reflex, Sector
from tegotae.parts.terms.base import (
    ConstantGain,
    OffsetAction,
    ReversingReaction,
    VanillaAction,
    VanillaReaction,
)
from tegotae.parts.terms.network import Network
from tegotae.systems.controller_file import SavedController

TWO_PI = 2.0 * math.pi
_SLACK = 1e-12
"""Widening per step that stands for rounding; the checker rounds outward itself."""
_LONGEST_S = 2.0
"""Longest stance that is followed [s]."""
FREE = 9999
"""Rank of a cell whose orbits stay in the set, but are not proved to reach the core."""
_LEAST_SPEED = 0.15
"""Least speed of lift-off [m/s]; a slower one could land again within its tick."""
_AT_ONCE = 4096
_MARGIN = 0.1
"""Share of an image's width by which it is widened before cells are compared."""
_TERMS: dict[str, tuple[type, ...]] = {
    "action": (VanillaAction, OffsetAction, Network),
    "reaction": (VanillaReaction, ReversingReaction, Network),
    "gain": (ConstantGain,),
    "actuation": (Sector, FreeSector, Reflex, LearnedActuation),
}
_INPUTS = {"action": {"phase"}, "reaction": {"spring_force"}, "actuation": {"phase", "feedback"}}
_NUMBERS = ("inputs", "start_rad", "width_rad", "newtons_per_feedback")
ERRORS = {"load": 0.0, "phase_rad": 1e-6, "force_n": 1e-4, "stiffness": 0.0, "mass": 0.0}
"""Errors of a tick that a certificate allows, of phase and force by single precision, and relative
errors of stiffness and mass, each constant along an orbit."""
BODY = (
    *("mass_kg", "stiffness_n_per_m", "damping_ns_per_m"),
    *("rest_length_m", "gravity_m_per_s2", "max_force_n"),
)
"""Numbers of the body of a certificate."""
Bounds = tuple[np.ndarray, np.ndarray]
"""Lower and upper bounds, [cells] each."""


class Form(NamedTuple):
    """Linear bound of a value over a box of phase φ and load N, [cells] each:
    |value - centre - by_phase (φ - φ_c) - by_load (N - N_c)| <= error."""

    centre: Any
    by_phase: Any
    by_load: Any
    error: Any


class Box(NamedTuple):
    """Box of phases [rad] and loads [weights of the body], [cells] each."""

    phase: Any
    phase_radius: Any
    load: Any
    load_radius: Any

    def spread(self, form: Form) -> Any:
        """Return the radius of a form over the box."""
        linear = np.abs(form.by_phase) * self.phase_radius + np.abs(form.by_load) * self.load_radius
        return linear + form.error


def _cosine(centre: Any, radius: Any) -> Bounds:
    """Return the range of cos over intervals."""
    lo, hi = centre - radius, centre + radius
    first, last = np.cos(lo), np.cos(hi)
    top = TWO_PI * np.ceil(lo / TWO_PI) <= hi
    bottom = TWO_PI * np.ceil((lo - math.pi) / TWO_PI) + math.pi <= hi
    return (
        np.where(bottom, -1.0, np.minimum(first, last)),
        np.where(top, 1.0, np.maximum(first, last)),
    )


def _scaled(a: Bounds, factor: float) -> Bounds:
    return (a[0] * factor, a[1] * factor) if factor >= 0.0 else (a[1] * factor, a[0] * factor)


def _network(weights: np.ndarray, box: Box, feedback: Form | None, *, phase: bool) -> Form:
    """Return the form of a network of the phase, of another input given as a form, or of both.

    By the mean value theorem: slopes over the box are intervals, of which the middle is kept.
    """
    cells = np.shape(box.phase)
    cosine, sine = (_cosine(box.phase - turn, box.phase_radius) for turn in (0.0, 0.5 * math.pi))
    spread = 0.0 if feedback is None else box.spread(feedback)
    value, slope_p, slope_x = np.zeros(cells), (0.0, 0.0), (0.0, 0.0)
    for *inputs, bias, out in weights.tolist():
        a = np.full(cells, bias)
        radius, turn = np.zeros(cells), None
        if phase:
            w_sin, w_cos, *inputs = inputs
            a = a + w_sin * np.sin(box.phase) + w_cos * np.cos(box.phase)
            p, q = _scaled(cosine, w_sin), _scaled(sine, -w_cos)
            turn = p[0] + q[0], p[1] + q[1]
            radius = radius + np.maximum(np.abs(turn[0]), np.abs(turn[1])) * box.phase_radius
        if feedback is not None:
            a = a + inputs[0] * feedback.centre
            radius = radius + abs(inputs[0]) * spread
        value = value + out * np.tanh(a)
        t0, t1 = np.tanh(a - radius), np.tanh(a + radius)
        flattest = np.where(t0 * t1 <= 0.0, 0.0, np.minimum(np.abs(t0), np.abs(t1)))
        slope = _scaled((1.0 - np.maximum(t0 * t0, t1 * t1), 1.0 - flattest**2), out)
        if turn is not None:
            corners = [s * x for s in slope for x in turn]
            slope_p = (
                slope_p[0] + np.minimum.reduce(corners),
                slope_p[1] + np.maximum.reduce(corners),
            )
        if feedback is not None:
            part = _scaled(slope, inputs[0])
            slope_x = slope_x[0] + part[0], slope_x[1] + part[1]
    by_phase, by_x = 0.5 * (slope_p[0] + slope_p[1]), 0.5 * (slope_x[0] + slope_x[1])
    error = 0.5 * (slope_p[1] - slope_p[0]) * box.phase_radius
    by_load = 0.0
    if feedback is not None:
        error = error + 0.5 * (slope_x[1] - slope_x[0]) * spread + np.abs(by_x) * feedback.error
        by_phase, by_load = by_phase + by_x * feedback.by_phase, by_x * feedback.by_load
    return Form(value, by_phase, by_load, error + _SLACK)


def _clipped(form: Form, spread: Any, limit_n: float) -> Form:
    """Return a form of a value that is clipped to [0, most], on the chord of its range."""
    lo, hi = form.centre - spread, form.centre + spread
    low, high = np.clip(lo, 0.0, limit_n), np.clip(hi, 0.0, limit_n)
    slope = (high - low) / np.maximum(hi - lo, 1e-9)
    gaps = [
        np.clip(x, 0.0, limit_n) - slope * (x - form.centre)
        for x in (lo, hi, np.clip(0.0, lo, hi), np.clip(limit_n, lo, hi))
    ]
    lowest, highest = np.minimum.reduce(gaps), np.maximum.reduce(gaps)
    error = 0.5 * (highest - lowest) + slope * form.error + _SLACK
    return Form(0.5 * (highest + lowest), slope * form.by_phase, slope * form.by_load, error)


@dataclass(frozen=True)
class BoundedLaw:
    """Sampled law of one leg, bounded over boxes of phase and load.

    Args:
        omega: ω [rad/s].
        terms: role, kind and numbers of each term, in the order of their weights, as in the file.
        weights: all weights.
        body: numbers of the body by name.
        weight_n: weight by which the law divides the sensed load [N].
        errors: bounds of the errors of the sensed load [weights of the body], and a tick of the
            phase [rad] and of the force [N], and relative errors of stiffness and mass.
    """

    omega: float
    terms: Sequence[Mapping[str, Any]]
    weights: np.ndarray
    body: Mapping[str, float]
    weight_n: float
    errors: Mapping[str, float]

    @property
    def fastest_rad_per_s(self) -> float:
        """The faster of the rates of stance and of its damping [rad/s]."""
        m = self.body["mass_kg"]
        return max(
            math.sqrt(self.body["stiffness_n_per_m"] / m), 4.0 * self.body["damping_ns_per_m"] / m
        )

    def term(self, role: str) -> tuple[Mapping[str, Any], np.ndarray]:
        """Return a term and its weights."""
        start = 0
        for term in self.terms:
            if term["role"] == role:
                return term, self.weights[start : start + term["weights"]]
            start += term["weights"]
        raise KeyError(role)

    def _action(self, box: Box) -> Form:
        term, weights = self.term("action")
        if term["kind"] == "Network":
            return _network(weights.reshape(-1, 4), box, None, phase=True)
        lo, hi = _cosine(box.phase - 0.5 * math.pi, box.phase_radius)
        value = -np.cos(box.phase) - (float(weights[0]) if len(weights) else 0.0)
        return Form(value, 0.5 * (lo + hi), 0.0, 0.5 * (hi - lo) * box.phase_radius + _SLACK)

    def _reaction(self, box: Box) -> Form:
        term, weights = self.term("reaction")
        if term["kind"] == "Network":
            load = Form(box.load, 0.0, 1.0, 0.0)
            return _network(weights.reshape(-1, 3), box, load, phase=False)
        if term["kind"] == "ReversingReaction":
            return Form(1.0 - weights[0] * box.load, 0.0, -weights[0], _SLACK)
        return Form(self.weight_n * box.load, 0.0, self.weight_n, _SLACK)

    def feedback(self, box: Box) -> Form:
        """Return the form of f = G A′ R [rad/s]."""
        sigma = float(self.term("gain")[1][0])
        a, r = self._action(box), self._reaction(box)
        product_error = 2.0 * box.spread(a) * box.spread(r)
        error = np.abs(a.centre) * r.error + np.abs(r.centre) * a.error + product_error
        return Form(
            sigma * a.centre * r.centre,
            sigma * r.centre * a.by_phase,
            sigma * a.centre * r.by_load,
            abs(sigma) * error,
        )

    def force(self, box: Box, feedback: Form) -> Form:
        """Return the form of the force [N]."""
        term, weights = self.term("actuation")
        limit_n, spread = self.body["max_force_n"], box.spread(feedback)
        if "inputs" in term:
            scale = 1.0 / math.sqrt(self.body["gravity_m_per_s2"] / self.body["rest_length_m"])
            source = Form(*(scale * x for x in feedback)) if "feedback" in term["inputs"] else None
            phase = "phase" in term["inputs"]
            columns = 2 * phase + (source is not None) + 2
            form = _network(weights.reshape(-1, columns), box, source, phase=phase)
            return _clipped(form, box.spread(form), limit_n)
        zero = np.zeros_like(box.phase)
        form = Form(zero, zero, zero, zero)
        if "newtons_per_feedback" in term:
            s = term["newtons_per_feedback"]
            f = feedback
            form = Form(-s * f.centre, -s * f.by_phase, -s * f.by_load, s * f.error)
            form = _clipped(form, s * spread, limit_n)
        if "Sector" in term["kind"]:
            start, width = weights if len(weights) else (term["start_rad"], term["width_rad"])
            first = (box.phase - box.phase_radius - start) % TWO_PI
            last = first + 2.0 * box.phase_radius
            inside = (first >= _SLACK) & (last < width - _SLACK)
            outside = (first > width + _SLACK) & (last < TWO_PI - _SLACK)
            reach = box.spread(form)
            lo = np.where(inside, limit_n, np.maximum(form.centre - reach, 0.0))
            hi = np.where(outside, np.minimum(form.centre + reach, limit_n), limit_n)
            form = Form(
                np.where(outside, form.centre, 0.5 * (lo + hi)),
                np.where(outside, form.by_phase, 0.0),
                np.where(outside, form.by_load, 0.0),
                np.where(outside, form.error, 0.5 * (hi - lo)),
            )
        return form


class Hop(NamedTuple):
    """Images of cells under one hop, [cells] each."""

    speed: Bounds
    """Speed at the first tick of the next stance [m/s]."""
    phase: Bounds
    """Phase there [rad], not wrapped."""
    lift_off: Bounds
    """Speed of lift-off [m/s]."""
    least_z: Any
    """Bound of the leg's length less its rest length from below [m]."""
    work_j: Any
    """Bound of the work ∫ |F ẏ| dt from above [J]."""
    hops: Any
    """True if every orbit of the cell hops."""


class _Stance(NamedTuple):
    """Orbits of cells in stance: affine in speed, time since touchdown and phase at its start."""

    q: Any
    p: Any
    phase: Any
    gq: Any
    gp: Any
    gphase: Any
    radius: Any
    phase_radius: Any
    ok: Any
    lifting: Any
    slope: Any
    lift_error: Any
    least_v: Any
    lift_ticks: Any
    least_z: Any
    work: Any


def hop(law: BoundedLaw, tick_s: float, speed: Bounds, phase: Bounds) -> Hop:
    """Return the images of cells of speed and phase at the first tick in stance under one hop.

    Args:
        law: the law.
        tick_s: control period T [s].
        speed: speed of the body [m/s].
        phase: phase [rad].
    """
    b, t = law.body, tick_s
    m, g, limit_n = b["mass_kg"], b["gravity_m_per_s2"], b["max_force_n"]
    e_load, e_phase, e_force, e_stiff, e_mass = (law.errors[name] for name in ERRORS)
    e_mass = e_mass / (1.0 - e_mass)
    softer, lighter = (np.eye(5)[3:] * [[e_stiff], [e_mass]])[..., None]
    stretch = (1.0 + e_stiff) * (1.0 + e_mass)
    stiff, damp = b["stiffness_n_per_m"] / m, b["damping_ns_per_m"] / m
    d = 0.5 * damp
    w = math.sqrt(stiff - d * d)
    decay = math.exp(-d * t)
    cosine, sine = decay * math.cos(w * t), decay * math.sin(w * t)
    # x = q, v = w p - d q: in (q, p) stance rotates about (1, d/w) (u - m g)/k and decays.
    push_q = (1.0 - cosine - sine * d / w) / (m * stiff)
    push_p = ((1.0 - cosine) * d / w + sine) / (m * stiff)
    push = t / (m * w)
    n = len(speed[0])
    zero = np.zeros(n)
    first_a = stretch * (limit_n / m + (damp + stiff * t) * speed[1]) + g
    deepest = 0.5 * t * (speed[1] + t * first_a)
    v_r, p_r = 0.5 * (speed[1] - speed[0]), 0.5 * (phase[1] - phase[0])
    s = _Stance(
        -deepest,
        (-0.5 * (speed[0] + speed[1]) - d * deepest) / w,
        0.5 * (phase[0] + phase[1]),
        np.stack([zero, deepest, zero, zero, zero]),
        np.stack([v_r / w, d * deepest / w, zero, zero, zero]),
        np.stack([zero, zero, p_r, zero, zero]),
        *(zero, zero, np.ones(n, bool), np.zeros(n, bool), zero, zero, zero + np.inf, zero),
        *(zero, zero),
    )
    rows, ends = np.arange(n), []
    for _ in range(int(_LONGEST_S / t)):
        if not len(rows):
            break
        z_r = np.abs(s.gq).sum(0) + s.radius
        v, gv = w * s.p - d * s.q, w * s.gp - d * s.gq
        v_r = np.abs(gv).sum(0) + s.radius * math.sqrt(stiff)
        # Load N = max(-z, 0) k / (m g), on the chord over the range of z.
        lo, hi = s.q - z_r, s.q + z_r
        deep, shallow = (np.maximum(-z, 0.0) * m * stiff / law.weight_n for z in (lo, hi))
        chord = (shallow - deep) / np.maximum(hi - lo, 1e-12)
        # Its largest error is at z = 0, where the chord is above.
        gap = np.where((lo < 0.0) & (hi > 0.0), deep + chord * -lo, 0.0)
        n_c = 0.5 * (deep + shallow - gap)
        n_r = 0.5 * (deep - shallow + gap)
        sense_r = e_load + e_stiff * n_r
        box = Box(
            s.phase,
            np.abs(s.gphase).sum(0) + s.phase_radius,
            n_c,
            n_r + sense_r + e_stiff * n_c,
        )
        g_load = chord * s.gq + softer * n_c
        f = law.feedback(box)
        u = law.force(box, f)
        u_r = box.spread(u) + e_force
        phase = s.phase + t * (law.omega + f.centre)
        gphase = s.gphase * (1.0 + t * f.by_phase) + t * f.by_load * g_load
        f_error = np.abs(f.by_load) * (np.abs(chord) * s.radius + 0.5 * gap + sense_r) + f.error
        phase_radius = np.abs(1.0 + t * f.by_phase) * s.phase_radius + t * f_error + e_phase
        gu = u.by_phase * s.gphase + u.by_load * g_load
        u_error = np.abs(u.by_phase) * s.phase_radius + u.error + e_force
        u_error = u_error + np.abs(u.by_load) * (np.abs(chord) * s.radius + 0.5 * gap + sense_r)
        # Lift-off: ℓ = v - κ z hardly changes along the flow, and is v where z = 0.
        a = -stiff * s.q - damp * v + u.centre / m - g
        a_most = stiff * (np.abs(s.q) + z_r) + damp * (np.abs(v) + v_r) + limit_n / m
        a_most = 1.03 * (stretch * a_most + g)
        # Another stiffness and mass: their first order moves the gens, the rest is an error.
        z_more, v_more = z_r + t * (np.abs(v) + v_r + t * a_most), v_r + t * a_most
        pull = -stiff * s.q
        inertial = pull - damp * v + u.centre / m
        spare = e_stiff * ((1.0 + e_mass) * stiff * z_more + e_mass * np.abs(pull))
        spare = spare + e_mass * (stiff * z_more + damp * v_more + u_r / m)
        gu, u_error = gu + m * (softer * pull + lighter * inertial), u_error + m * spare
        spare = spare + e_stiff * np.abs(pull) + e_mass * np.abs(inertial)
        slope = np.where(s.lifting, s.slope, a / np.where(v > 0.0, v, np.inf))
        change = np.abs(a - slope * v) + stiff * z_r + np.abs(damp + slope) * v_r + u_r / m
        change = change + spare
        change = change + t * (stiff * (np.abs(v) + v_r) + np.abs(damp + slope) * a_most)
        least_v, most_v = v - v_r - t * a_most, v + v_r + t * a_most
        fastest = np.abs(v) + v_r
        c = u.centre - m * g
        q, p = cosine * s.q + sine * s.p + push_q * c, cosine * s.p - sine * s.q + push_p * c
        gq = cosine * s.gq + sine * s.gp + push_q * gu
        gp = cosine * s.gp - sine * s.gq + push_p * gu
        radius = decay * s.radius + push * u_error + _SLACK
        z_r = np.abs(gq).sum(0) + radius
        v_next, gv = w * p - d * q, w * gp - d * gq
        next_r = np.abs(gv).sum(0) + radius * math.sqrt(stiff)
        fastest = 0.5 * (fastest + np.abs(v_next) + next_r) * (1.0 + 2.0 * t * t * stiff)
        lifts = (q + z_r >= -t * t * a_most) & (most_v >= 0.0)  # within the tick, too
        lifting = s.lifting | lifts
        s = _Stance(
            *(q, p, phase, gq, gp, gphase, radius, phase_radius),
            s.ok
            & (~lifts | (least_v > _LEAST_SPEED))
            & (q - z_r - t * t * a_most > -b["rest_length_m"]),
            lifting,
            slope,
            np.where(lifting, s.lift_error + t * change, 0.0),
            np.where(lifting, np.minimum(s.least_v, least_v), np.inf),
            s.lift_ticks + lifting,
            np.minimum(s.least_z, q - z_r - t * t * a_most),
            s.work + np.minimum(u.centre + u_r, limit_n) * t * fastest,
        )
        ended = (lifts & (q - z_r >= 0.0)) | ~s.ok
        if ended.any():
            ends.append((rows[ended], _Stance(*(x[..., ended] for x in s))))
            rows, s = rows[~ended], _Stance(*(x[..., ~ended] for x in s))
    ends.append((rows, s._replace(ok=np.zeros(len(rows), bool))))
    order = np.argsort(np.concatenate([rows for rows, _ in ends]))
    joined = (
        np.concatenate(x, axis=-1)[..., order] for x in zip(*(e for _, e in ends), strict=True)
    )
    return _flight(law, t, _Stance(*joined), w, d)


def _flight(law: BoundedLaw, tick_s: float, s: _Stance, w: float, d: float) -> Hop:
    """Return the images after flight of orbits that have all left the ground by a tick.

    The phase goes on as in stance without load. Speed of lift-off and time of touchdown are affine,
    too.
    """
    b, t, ok = law.body, tick_s, s.ok
    m, g, limit_n = b["mass_kg"], b["gravity_m_per_s2"], b["max_force_n"]
    e_load, e_phase, e_force, e_stiff, e_mass = (law.errors[name] for name in ERRORS)
    v, gv = w * s.p - d * s.q, w * s.gp - d * s.gq
    v = np.where(ok, v, 1.0)
    speed, g_speed = v - s.slope * s.q, gv - s.slope * s.gq
    stiff = w * w + d * d
    e_speed = s.radius * np.hypot(w, d + s.slope) + s.lift_error
    z_r = np.abs(s.gq).sum(0) + s.radius
    v_r = np.abs(gv).sum(0) + s.radius * math.sqrt(stiff)
    # Time since lift-off z / v̄, with v̄ between the least and the largest speed on the way.
    least_v = np.where(ok, np.minimum(s.least_v, v - v_r), 1.0)
    a_most = stiff * (np.abs(s.q) + z_r) + 2.0 * d * (np.abs(v) + v_r) + limit_n / m + g
    most_v = v + v_r + (s.lift_ticks + 1.0) * t * a_most
    e_time = s.radius / v + (s.q + z_r) * np.maximum(
        1.0 / least_v - 1.0 / v, 1.0 / v - 1.0 / most_v
    )
    touch = 2.0 * speed / g - s.q / v
    g_touch = 2.0 * g_speed / g - s.gq / v
    e_touch = 2.0 * e_speed / g + e_time
    touch_r = np.abs(g_touch).sum(0) + e_touch
    ok = ok & (touch - touch_r > 2.0 * t) & (touch + touch_r < 4.0)
    touch, touch_r = np.where(ok, touch, 2.0 * t), np.where(ok, touch_r, 0.0)
    first = np.floor((touch - touch_r) / t - 1e-9)
    last = np.floor((touch + touch_r) / t + 1e-9) + 1.0
    phase, gphase, radius = s.phase, s.gphase, s.phase_radius
    landed = phase, gphase, radius
    rate = np.full(len(phase), np.inf), np.full(len(phase), -np.inf)
    departures = rate
    for j in range(int(last.max(initial=0.0)) + 1):
        reach = np.abs(gphase).sum(0) + radius
        box = Box(phase, reach, np.zeros_like(phase), np.full_like(phase, e_load))
        f = law.feedback(box)
        f_r = box.spread(f)
        window = (j >= first) & (j <= last)
        landed = tuple(
            np.where(j <= first, x, y) for x, y in zip((phase, gphase, radius), landed, strict=True)
        )
        rate, departures = (
            (
                np.where(window, np.minimum(a[0], c - r), a[0]),
                np.where(window, np.maximum(a[1], c + r), a[1]),
            )
            for a, c, r in ((rate, law.omega + f.centre, f_r), (departures, phase, reach))
        )
        phase = phase + t * (law.omega + f.centre)
        gphase = gphase * (1.0 + t * f.by_phase)
        radius = np.abs(1.0 + t * f.by_phase) * radius + e_phase
        radius = radius + t * (f.error + np.abs(f.by_load) * e_load)
    # From the tick `first` to the first tick after touchdown: its time is touch + θ, 0 < θ <= T.
    phase, gphase, radius = landed
    mean, mean_r = 0.5 * (rate[0] + rate[1]), 0.5 * (rate[1] - rate[0])
    mean, mean_r = np.where(ok, mean, 0.0), np.where(ok, mean_r, 0.0)
    ahead = touch + 0.5 * t - first * t
    reach = np.abs(gphase + mean * g_touch).sum(0) + radius + (last - first + 1.0) * e_phase
    reach = reach + np.abs(mean) * (e_touch + 0.5 * t) + mean_r * (ahead + touch_r + 0.5 * t)
    phase = phase + mean * ahead
    middle, half = 0.5 * (departures[0] + departures[1]), 0.5 * (departures[1] - departures[0])
    middle, half = np.where(ok, middle, 0.0), np.where(ok, half, 0.0)
    box = Box(middle, half, np.zeros_like(middle), np.full_like(middle, e_load))
    force = law.force(box, law.feedback(box))
    force_r = box.spread(force) + e_force
    speed_r = np.abs(g_speed).sum(0) + e_speed
    lift_off = speed - speed_r, speed + speed_r
    fastest = lift_off[1] * 1.01 + 0.1
    stretch = (1.0 + e_stiff) / (1.0 - e_mass)
    rises = (force.centre + force_r) / m * stretch - g + (2.0 * d + stiff * t) * stretch * fastest
    falls = g - (force.centre - force_r) / m * (1.0 - e_mass)
    image = lift_off[0] - t * np.maximum(rises, 0.0), lift_off[1] + t * np.maximum(falls, 0.0)
    work = s.work + np.minimum(force.centre + force_r, limit_n) * t * fastest
    return Hop(image, (phase - reach, phase + reach), lift_off, s.least_z, work, ok)


@dataclass(frozen=True)
class Grid:
    """Cells of speed and phase: a strip of speeds times the circle.

    Args:
        least_speed: least speed [m/s].
        largest_speed: largest speed [m/s].
        speeds: number of cells over the speeds.
        phases: number of cells over the circle.
    """

    least_speed: float
    largest_speed: float
    speeds: int
    phases: int

    def cells(self) -> tuple[Bounds, Bounds]:
        """Return speeds [m/s] and phases [rad] of all cells, [cells], the phases innermost."""
        v = np.linspace(self.least_speed, self.largest_speed, self.speeds + 1)
        p = np.linspace(0.0, TWO_PI, self.phases + 1)
        i, j = (x.ravel() for x in np.indices((self.speeds, self.phases)))
        return (v[i], v[i + 1]), (p[j], p[j + 1])

    def rectangles(self, image: Hop) -> np.ndarray:
        """Return first and last index over speeds and phases of the cells that an image meets.

        [cells, 4]; the phases wrap, and a cell without image has first speed -1.
        """
        per_v, per_p = self.speeds / (self.largest_speed - self.least_speed), self.phases / TWO_PI
        v0 = np.floor((image.speed[0] - self.least_speed) * per_v - 1e-6)
        v1 = np.floor((image.speed[1] - self.least_speed) * per_v + 1e-6)
        p0 = np.floor(image.phase[0] * per_p - 1e-6)
        p1 = np.floor(image.phase[1] * per_p + 1e-6)
        ok = image.hops & (v0 >= 0) & (v1 < self.speeds)
        ok &= (p1 - p0 < self.phases) & (np.abs(p0) < 1e9)  # false for no number, too
        shift = np.floor(p0 / self.phases) * self.phases
        rows = np.stack([v0, v1, p0 - shift, p1 - shift], axis=-1)
        rows[~ok] = (-1, 0, 0, 0)
        return rows.astype(int)


def contained(members: np.ndarray, rectangles: np.ndarray) -> np.ndarray:
    """Return for each rectangle of cells whether all of them are kept.

    Args:
        members: [speeds, phases].
        rectangles: first and last index over speeds and phases, [cells, 4].
    """
    twice = np.concatenate([members, members], axis=1)
    sums = np.zeros((twice.shape[0] + 1, twice.shape[1] + 1), int)
    sums[1:, 1:] = twice.cumsum(0).cumsum(1)
    v0, v1, p0, p1 = rectangles.T
    inside = sums[v1 + 1, p1 + 1] - sums[v0, p1 + 1] - sums[v1 + 1, p0] + sums[v0, p0]
    return (v0 >= 0) & (inside == (v1 - v0 + 1) * (p1 - p0 + 1))


def largest_set(grid: Grid, rectangles: np.ndarray) -> np.ndarray:
    """Return the largest collection of cells whose images lie in the collection."""
    members = np.ones((grid.speeds, grid.phases), bool)
    while True:
        smaller = members & contained(members, rectangles).reshape(members.shape)
        if (smaller == members).all():
            return members
        members = smaller


def ranked(members: np.ndarray, rectangles: np.ndarray) -> np.ndarray:
    """Return the rank of every cell: after so many hops all its orbits are in the core.

    The core is the smallest closed collection of cells that one orbit reaches. A cell outside of
    the set has rank -1.

    Args:
        members: closed collection of cells, [speeds, phases].
        rectangles: images of the cells, [cells, 4].

    Returns:
        [speeds, phases].
    """
    columns = members.shape[1]
    cell = int(np.flatnonzero(members.ravel())[members.sum() // 2])
    for _ in range(1000):
        v0, v1, p0, p1 = rectangles[cell]
        cell = (v0 + v1) // 2 * columns + (p0 + p1) // 2 % columns
    core, fresh = np.zeros(members.shape, bool), {cell}
    while fresh:
        reached: set[int] = set()
        for cell in fresh:
            core.ravel()[cell] = True
            v0, v1, p0, p1 = rectangles[cell]
            rows, wrapped = np.arange(v0, v1 + 1), np.arange(p0, p1 + 1) % columns
            reached |= set((rows[:, None] * columns + wrapped).ravel().tolist())
        fresh = {x for x in reached if not core.ravel()[x]}
    ranks = np.where(members, FREE, -1)
    inside, rank = core, 0
    while True:
        ranks[inside & (ranks == FREE)] = rank
        larger = members & (inside | contained(inside, rectangles).reshape(members.shape))
        if (larger == inside).all():
            return ranks
        inside, rank = larger, rank + 1


def bounded_law(saved: SavedController, **errors: float) -> BoundedLaw:
    """Return the law of a saved controller, if it has terms whose bounds are known.

    Args:
        saved: the controller.
        errors: errors that differ from those of `ERRORS`.

    Raises:
        TegotaeError: for another body than a linear hopper, or another term.
    """
    body, controller = saved.body, saved.system.controller
    if type(body) is not Hopper or body.leg_friction_n or body.flight_damping_ns_per_m:
        raise TegotaeError(
            f"certify bounds the motion of a Hopper without friction and damping in flight; "
            f"{saved.name} has another body, a {type(body).__name__}"
        )
    terms = []
    for role, term in controller.terms.items():
        kind = type(term)
        if kind not in _TERMS.get(role, ()):
            raise TegotaeError(
                f"certify has no bounds of {kind.__name__}, the {role} of {saved.name}; it has "
                f"those of {', '.join(x.__name__ for x in _TERMS[role])}"
            )
        if isinstance(term, Network) and not set(term.inputs) <= _INPUTS[role]:
            raise TegotaeError(
                f"certify has no bounds of a network of {', '.join(term.inputs)} as {role}; its "
                f"inputs may be {', '.join(sorted(_INPUTS[role]))}"
            )
        numbers = {name: getattr(term, name) for name in _NUMBERS if hasattr(term, name)}
        if getattr(term, "duration_s", 0.0):
            raise TegotaeError("certify has no bounds of a sector with a duration; give its width")
        terms.append({"role": role, "kind": kind.__name__, "weights": term.n_weights, **numbers})
    tegotae, oscillator = controller.tegotae, controller.oscillator
    plain = isinstance(oscillator, PhaseOscillator) and oscillator.slowest_rad_per_s is None
    if tegotae is None or tegotae.limit_rad_per_s is not None or not plain or saved.omega is None:
        raise TegotaeError(
            f"certify bounds φ̇ = ω + G A′ R of a phase oscillator; {saved.name} has another law"
        )
    numbers = {name: float(getattr(body, name)) for name in BODY}
    weights = np.asarray(saved.weights, float)
    weight_n = numbers["mass_kg"] * numbers["gravity_m_per_s2"]
    return BoundedLaw(saved.omega, terms, weights, numbers, weight_n, {**ERRORS, **errors})


def certificate(
    law: BoundedLaw, tick_s: float, grid: Grid, name: str, splits: int = 1
) -> JsonObject:
    """Search the largest certified set on a grid; return the certificate as JSON values.

    Its cells have ranks: -1 outside of the set, `FREE`, or the number of hops after which all
    orbits are in the core.

    Args:
        law: the law, with its body and the errors that are allowed.
        tick_s: control period [s].
        grid: cells of speed and phase.
        name: of the controller.
        splits: parts of the range of mass and of that of stiffness; each part is bounded alone.

    Raises:
        TegotaeError: if no cell is certified.
    """
    image = _images(law, tick_s, grid, splits)
    rectangles = grid.rectangles(image)
    members = largest_set(grid, rectangles)
    if not members.any():
        raise TegotaeError(
            f"no cell of {name} stays in a set: {image.hops.mean():.0%} of them hop; "
            "take more cells of speed and phase, other speeds, or a shorter tick"
        )
    ranks = ranked(members, rectangles)
    inside, lasting = (ranks >= 0).ravel(), ((ranks == 0) | (ranks == FREE)).ravel()
    g, length = law.body["gravity_m_per_s2"], law.body["rest_length_m"]
    climbs = tuple(x * x / (2.0 * g) for x in image.lift_off)
    merit = climbs[0][lasting] / image.work_j[lasting]

    def apexes(cells: np.ndarray) -> list[float]:
        return [length + climbs[0][cells].min() - 1e-6, length + climbs[1][cells].max() + 1e-6]

    return as_json(
        {
            "format": "tegotae certificate",
            "version": 1,
            "name": name,
            "law": {
                "omega_rad_per_s": law.omega,
                "tick_s": tick_s,
                "terms": law.terms,
                "weights": law.weights,
            },
            "sha256": weights_hash(law.weights),
            "body": law.body,
            "errors": law.errors,
            "splits": splits,
            "grid": {
                "least_m_per_s": grid.least_speed,
                "most_m_per_s": grid.largest_speed,
                "speeds": grid.speeds,
                "phases": grid.phases,
            },
            "claims": {
                "apex_m": apexes(inside),
                "lasting_apex_m": apexes(lasting),
                "least_height_m": length + image.least_z[inside].min() - 1e-3,
                "cot_inverse_m_per_j": 0.98 * merit.min(),
            },
            "ranks": ranks,
        }
    )


def weights_hash(weights: np.ndarray) -> str:
    """Return the SHA-256 of weights as little-endian doubles."""
    return hashlib.sha256(np.asarray(weights, "<f8").tobytes()).hexdigest()


def _split(law: BoundedLaw, splits: int) -> Iterator[BoundedLaw]:
    """Yield the law on bodies whose errors together cover all masses and stiffnesses."""
    parts = range(1 - splits, splits, 2)
    for places in itertools.product(parts, parts):
        body, errors = dict(law.body), dict(law.errors)
        for name, place in zip(("mass", "stiffness"), places, strict=True):
            entry = "mass_kg" if name == "mass" else "stiffness_n_per_m"
            body[entry] *= 1.0 + law.errors[name] * place / splits
            errors[name] /= splits * (1.0 - law.errors[name])
        yield replace(law, body=body, errors=errors)


def _joined(a: Hop, b: Hop) -> Hop:
    """Return the smallest bounds that contain both images."""
    speed, phase, lift_off = (
        (np.minimum(x[0], y[0]), np.maximum(x[1], y[1])) for x, y in zip(a[:3], b[:3], strict=True)
    )
    least_z, work = np.minimum(a.least_z, b.least_z), np.maximum(a.work_j, b.work_j)
    return Hop(speed, phase, lift_off, least_z, work, a.hops & b.hops)


def _images(law: BoundedLaw, tick_s: float, grid: Grid, splits: int) -> Hop:
    """Return the images of all cells, wider by what another program's bounds may be."""
    speeds, phases = grid.cells()

    def image_of(member: BoundedLaw) -> Hop:
        parts = []
        for start in range(0, len(speeds[0]), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            ends = ((x[0][part], x[1][part]) for x in (speeds, phases))
            parts.append(hop(member, tick_s, *ends))
        return jax.tree.map(lambda *x: np.concatenate(x), *parts)

    image = functools.reduce(_joined, map(image_of, _split(law, splits)))

    def wider(x: Bounds) -> Bounds:
        margin = _MARGIN * (x[1] - x[0]) + 1e-6
        return x[0] - margin, x[1] + margin

    bounds = {name: wider(getattr(image, name)) for name in ("speed", "phase", "lift_off")}
    return image._replace(**bounds)
