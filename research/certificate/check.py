"""Check a certificate that a sampled law makes a one-legged hopper hop for ever (theorem: page.md).

python check.py CERTIFICATE.json [CONTROLLER.json]

It needs Python and NumPy alone, and has no code in common with the program that wrote the file.
"""

import hashlib
import json
import struct
import sys
from pathlib import Path

import numpy as np

U = 2.0**-52  # twice the relative error of an operation of IEEE 754
LIBM = 2.0**-49  # assumed bound of the error of NumPy's cos, sin, tanh and exp of x <= 0
UP = 1.0 + 2.0**-46  # more than the rounding of 32 operations on radii, which are positive
TURN = 2.0 * np.pi  # within 1e-15 of 2 pi
FREE = 9999  # rank of a cell whose orbits stay in the set, but perhaps never reach the core


class RefusedError(Exception):
    """The reason why a certificate is not accepted."""


class Ball:
    """All real numbers within r of c; an operation adds its rounding error to the radius."""

    def __init__(self, c, r=0.0):
        self.c, self.r = np.asarray(c, float), np.asarray(r, float)

    mag = property(lambda self: (np.abs(self.c) + self.r) * UP)
    lo = property(lambda self: np.nextafter(self.c - self.r, -np.inf))
    hi = property(lambda self: np.nextafter(self.c + self.r, np.inf))

    def __add__(self, operand):
        c = self.c + ball(operand).c
        return Ball(c, (self.r + ball(operand).r + np.abs(c) * U) * UP)

    def __mul__(self, operand):
        c, b = self.c * ball(operand).c, ball(operand)
        return Ball(c, (self.r * b.mag + np.abs(self.c) * b.r + np.abs(c) * U + 1e-300) * UP)

    def __truediv__(self, operand):
        c, b = self.c / ball(operand).c, ball(operand)
        lowest = np.abs(b.c) - b.r
        if not np.all(lowest > 0.0):
            raise RefusedError("a divisor may be zero")
        return Ball(c, ((self.r + np.abs(c) * b.r) / (lowest * (1.0 - U)) + np.abs(c) * 4 * U) * UP)

    __radd__, __rmul__ = __add__, __mul__
    __rtruediv__ = lambda self, operand: ball(operand) / self  # noqa: E731
    __neg__ = lambda self: Ball(-self.c, self.r)  # noqa: E731
    __sub__ = lambda self, operand: self + -ball(operand)  # noqa: E731
    __rsub__ = lambda self, operand: ball(operand) + -self  # noqa: E731

    def grown(self, *radii):
        return Ball(self.c, total(self.r, *radii))


def ball(x):
    return x if isinstance(x, Ball) else Ball(x)


def total(*radii):
    return sum(radii) * UP


def hull(lo, hi):
    c = 0.5 * (lo + hi)
    return Ball(c, (np.maximum(hi - c, c - lo) + np.abs(c) * U) * UP)


def pick(mask, end_state, start_state):
    if isinstance(end_state, Ball):
        return Ball(
            np.where(mask, end_state.c, start_state.c), np.where(mask, end_state.r, start_state.r)
        )
    return np.where(mask, end_state, start_state)


def smooth(function, x):
    """A function whose slope is at most 1 in size, on a ball."""
    return Ball(function(x.c), total(x.r, LIBM))


def cosine(x):
    """The range of cos on balls, by its ends and its extremes."""
    ends, lo, hi = (np.cos(x.lo), np.cos(x.hi)), x.lo / TURN, x.hi / TURN
    top, bottom = (np.ceil(lo - s - 1e-9) <= hi - s + 1e-9 for s in (0.0, 0.5))
    lowest = np.where(bottom, -1.0, np.minimum(*ends) - LIBM)
    return hull(lowest, np.where(top, 1.0, np.maximum(*ends) + LIBM))


class Box:
    """Phases within phase_r of the phase [rad], loads within load_r of the load [weights]."""

    def __init__(self, phase, phase_r, load, load_r):
        self.phase, self.phase_r, self.load, self.load_r = phase, phase_r, load, load_r
        self.zero, self.around = Ball(np.zeros_like(phase)), Ball(phase, phase_r)
        self.sine = cosine(self.around - Ball(TURN / 4, 1e-15))


class Form:
    """Mean value form of a value on a box: centre + by_phase (φ - φ_c) + by_load (N - N_c), where
    the balls by_phase and by_load contain all slopes over the box."""

    def __init__(self, centre, by_phase, by_load, box):
        self.centre, self.by_phase, self.by_load, self.box = centre, by_phase, by_load, box
        self.linear_r = total(by_phase.mag * box.phase_r, by_load.mag * box.load_r)
        self.range = centre.grown(self.linear_r)

    def __mul__(self, k):
        return Form(self.centre * k, self.by_phase * k, self.by_load * k, self.box)


def network(weights, box, phase, x):
    """A network of (sin φ, cos φ) if `phase`, and of the value of the form x if there is one."""
    value = by_phase = by_x = box.zero
    cos, corners = cosine(box.around), [smooth(f, Ball(box.phase)) for f in (np.sin, np.cos)]
    for *inputs, bias, out in weights:
        a, turn, w = box.zero + bias, box.zero, inputs[-1] if x is not None else 0.0
        if phase:
            a = a + corners[0] * inputs[0] + corners[1] * inputs[1]
            turn = cos * inputs[0] - box.sine * inputs[1]
        around = a if x is None else a + x.range * w
        a = a if x is None else a + Ball(x.centre.c) * w
        around = around.grown(turn.mag * box.phase_r)
        value = value + smooth(np.tanh, a) * out
        ends = np.tanh(around.lo), np.tanh(around.hi)
        near = np.where(ends[0] * ends[1] <= 0.0, 0.0, np.minimum(*np.abs(ends)) - LIBM)
        near, far = Ball(np.maximum(near, 0.0)), Ball(np.minimum(np.max(np.abs(ends), 0) + LIBM, 1))
        slope = hull((1.0 - far * far).lo, (1.0 - near * near).hi) * out
        by_phase, by_x = by_phase + slope * turn, by_x + slope * w
    if x is None:
        return Form(value, by_phase, box.zero, box)
    by_phase, by_load = by_phase + by_x * x.by_phase, by_x * x.by_load
    return Form(value.grown(by_x.mag * x.centre.r), by_phase, by_load, box)


def clipped(form, max_n):
    """A form clipped to [0, most], on a line through the ends of its range."""
    lo, hi = form.range.lo, form.range.hi
    line = (np.clip(hi, 0, max_n) - np.clip(lo, 0, max_n)) / np.maximum(hi - lo, 1e-9)
    bends = (lo, hi, np.clip(0.0, lo, hi), np.clip(max_n, lo, hi))
    gaps = [Ball(np.clip(x, 0, max_n)) - (Ball(x) - form.centre.c) * line for x in bends]
    centre = hull(np.min([gap.lo for gap in gaps], 0), np.max([gap.hi for gap in gaps], 0))
    centre = centre.grown(np.abs(line) * form.centre.r)
    return Form(centre, form.by_phase * line, form.by_load * line, form.box)


class Law:
    """The law of a certificate: forms of its feedback [rad/s] and of its force [N] on boxes."""

    def __init__(self, law, body):
        self.omega, self.tick, self.terms, start = law["omega_rad_per_s"], law["tick_s"], {}, 0
        for term in law["terms"]:
            weights = law["weights"][start : start + term["weights"]]
            self.terms[term["role"]], start = (term["kind"], term, weights), start + len(weights)
        if start != len(law["weights"]) or len(self.terms) != 4:
            raise RefusedError("the terms do not fit the weights")
        self.weight_n = Ball(body["mass_kg"]) * body["gravity_m_per_s2"]
        root = np.sqrt(body["gravity_m_per_s2"] / body["rest_length_m"])
        self.scale, self.max_n = 1.0 / Ball(root, root * 4 * U), body["max_force_n"]

    def feedback(self, box):
        kind, _, weights = self.terms["action"]
        if kind == "Network":
            action = network(np.reshape(weights, (-1, 4)).tolist(), box, True, None)
        elif kind in ("VanillaAction", "OffsetAction"):
            value = -smooth(np.cos, Ball(box.phase)) - (weights[0] if weights else 0.0)
            action = Form(value, box.sine, box.zero, box)
        else:
            raise RefusedError(f"no action {kind} is known here")
        kind, _, weights = self.terms["reaction"]
        load = Form(Ball(box.load), box.zero, box.zero + 1.0, box)
        if kind == "Network":
            reaction = network(np.reshape(weights, (-1, 3)).tolist(), box, False, load)
        elif kind == "ReversingReaction":
            reaction = Form(1.0 - load.centre * weights[0], box.zero, box.zero - weights[0], box)
        elif kind == "VanillaReaction":
            reaction = load * self.weight_n
        else:
            raise RefusedError(f"no reaction {kind} is known here")
        if self.terms["gain"][0] != "ConstantGain":
            raise RefusedError(f"no gain {self.terms['gain'][0]} is known here")
        by_phase, by_load = action.by_phase * reaction.range, reaction.by_load * action.range
        product = Form(action.centre * reaction.centre, by_phase, by_load, box)
        return product * self.terms["gain"][2][0]

    def force(self, box, feedback):
        kind, term, weights = self.terms["actuation"]
        if kind == "LearnedActuation":
            x = feedback * self.scale if "feedback" in term["inputs"] else None
            columns = 2 * ("phase" in term["inputs"]) + (x is not None) + 2
            rows = np.reshape(weights, (-1, columns)).tolist()
            return clipped(network(rows, box, "phase" in term["inputs"], x), self.max_n)
        if kind == "Reflex":
            return clipped(feedback * -term["newtons_per_feedback"], self.max_n)
        if kind not in ("Sector", "FreeSector"):
            raise RefusedError(f"no actuation {kind} is known here")
        free = kind == "FreeSector"
        start, width = weights if free else (term["start_rad"], term["width_rad"])
        first = (box.phase - box.phase_r - start) % TURN
        last, half = first + 2.0 * box.phase_r, Ball(0.5 * self.max_n, 0.5 * self.max_n)
        outside = (first > width + 1e-9) & (last < TURN - 1e-9)
        inside = (first > 1e-9) & (last < width - 1e-9)
        force = pick(inside, Ball(self.max_n), pick(outside, Ball(0.0), half))
        return Form(force, box.zero, box.zero, box)


def hop(law, body, errors, speed, phase):
    """Images of cells under one hop, from the first tick in stance to that of the next stance.

    An orbit is centre + Σ gens ε, ε in [-1, 1]⁵ (speed, time since touchdown, phase, stiffness,
    1/mass), with a disc for (q, p). z = q is the leg's length less that at rest, and its speed
    v = w p - d q.
    """
    m, g, max_n, t = Ball(body["mass_kg"]), body["gravity_m_per_s2"], law.max_n, law.tick
    e_load, e_phase, e_force = (errors[name] for name in ("load", "phase_rad", "force_n"))
    e_stiff, e_mass = errors["stiffness"], errors["mass"] / (1.0 - errors["mass"]) * UP
    softer, lighter = (np.eye(5)[3:] * [[e_stiff], [e_mass]])[..., None]
    stretch = (1.0 + e_stiff) * (1.0 + e_mass) * UP  # largest factor of the leg's acceleration
    k, C = body["stiffness_n_per_m"], body["damping_ns_per_m"] / m
    K = k / m
    d = C * 0.5
    w2 = K - d * d
    if not (w2.lo > 0.0 and (K * t * t + C * t).hi * stretch < 0.01):
        raise RefusedError("the tick is too long, or the leg too damped")
    w, root_K = hull(np.sqrt(w2.lo) * (1 - U), np.sqrt(w2.hi) * (1 + U)), np.sqrt(K.hi) * UP
    decay = smooth(np.exp, -d * t)
    cos, sin = decay * smooth(np.cos, w * t), decay * smooth(np.sin, w * t)
    # A newton over a tick shifts (q, p) by (1 - rotation) ((1, d/w)/k), at most T/(m w).
    push_q = (1.0 - cos - sin * d / w) / k
    push_p = ((1.0 - cos) * d / w + sin) / k
    zero = np.zeros_like(speed[0])
    a = ((max_n / m + (C + K * t) * speed[1] + e_force / m) * stretch + g).mag * 1.02
    deep = 0.5 * t * (speed[1] + t * a) * UP  # the first tick is within T of touchdown
    v, f = hull(*speed), hull(*phase)
    q, p, tilt = Ball(-deep), (-Ball(v.c) - d * deep) / w, d * deep / w
    gq, gf = (Ball(np.stack([zero, *x, zero, zero])) for x in ((deep, zero), (zero, f.r)))
    gp = np.stack([(Ball(v.r) / w).mag, tilt.c, *[zero] * 3])
    gp = Ball(gp, np.stack([zero, tilt.r, *[zero] * 3]))
    f, radius, on, lifting, slow = Ball(f.c, zero), zero, zero == 0.0, zero > 0.0, zero + np.inf
    kappa = drift = fast = low = work = zero

    def extent(q, p, gq, gp, radius):
        """Bounds of q and v around their centres, v and its gens."""
        v, gv = w * p - d * q, w * gp - d * gq
        z_r, v_r = total(gq.mag.sum(0), radius, q.r), total(gv.mag.sum(0), radius * root_K, v.r)
        return z_r, v_r, v, gv

    for _ in range(int(2.0 / t)):
        z_r, v_r, v, _ = extent(q, p, gq, gp, radius)
        # Load N = max(-z, 0) k/(m g), a convex function, around a chord over the range of z.
        ends = np.nextafter(q.c - z_r, -np.inf), np.nextafter(q.c + z_r, np.inf)
        ends = (*ends, np.clip(0.0, *ends))
        corners = [Ball(np.maximum(-z, 0.0)) * k / law.weight_n for z in ends]
        chord = (corners[1].c - corners[0].c) / np.maximum(ends[1] - ends[0], 1e-12)
        gaps = [x - (Ball(z) - q.c) * chord for x, z in zip(corners, ends, strict=True)]
        load = hull(np.min([x.lo for x in gaps], 0), np.max([x.hi for x in gaps], 0))
        load_r = total(np.maximum(corners[0].hi - load.c, load.c - corners[1].lo))
        sense_r = total(e_load, e_stiff * load_r)
        load_r = total(load_r, sense_r, e_stiff * np.abs(load.c))
        g_load = gq * chord + Ball(load.c) * softer
        box = Box(f.c, total(gf.mag.sum(0), f.r), load.c, load_r)
        rate = law.feedback(box)
        force, parts = law.force(box, rate), []
        for form in (rate, force):  # linear in the gens, and the radius of what that leaves
            error = (radius + q.r) * np.abs(chord) + load.r + sense_r
            error = np.abs(form.by_phase.c) * f.r * (form is force) + np.abs(form.by_load.c) * error
            error = error + form.by_phase.r * box.phase_r + form.by_load.r * load_r + form.centre.r
            gens = gf * form.by_phase.c + g_load * form.by_load.c
            parts.append((gens, error * UP))
        (g_rate, rate_e), (g_force, force_e) = parts
        own_r = (Ball(rate.by_phase.c) * t + 1.0).mag * f.r
        f_next = (Ball(f.c) + (Ball(rate.centre.c) + law.omega) * t).grown(
            t * rate_e, own_r, e_phase
        )
        u, u_r = Ball(force.centre.c), total(force.range.r, e_force)
        # Bounds over the tick: acceleration, speed, and change of ℓ = v - κ z, v at lift-off.
        y = total(np.abs(v.c), v_r)
        a = K * (np.abs(q.c) + z_r + t * y) + C * y + (max_n + e_force) / m
        a = (a * stretch + g).mag * 1.02
        # Another stiffness and mass: their first order moves the gens, the rest is an error.
        z_more, v_more = total(z_r, t * (y + t * a)), total(v_r, t * a)
        pull = K * -Ball(q.c)
        inertial, varied = pull - C * Ball(v.c) + u / m, (K * z_more).mag
        g_force = g_force + (pull * softer + inertial * lighter) * m
        spare = e_stiff * (1.0 + e_mass) * varied + e_stiff * e_mass * pull.mag
        spare = total(spare, e_mass * total(varied, (C * v_more).mag, u_r / m.lo))
        force_e = total(force_e, (m * spare).mag)
        spare = total(spare, e_stiff * pull.mag, e_mass * inertial.mag)
        v_lo, v_hi, change = (
            v.c - v_r - t * a * UP,
            v.c + v_r + t * a * UP,
            u / m - K * q - C * v - g,
        )
        kappa_next = np.where(lifting, kappa, change.c / np.where(v.c > 0.0, v.c, np.inf))
        change = (change - v * kappa_next).mag + K.mag * (z_r + t * (y + t * a)) + u_r / m.lo
        change, x = total(change, (C + kappa_next).mag * (v_r + t * a), spare), u - m * g
        new_q, new_p = cos * q + sin * p + push_q * x, cos * p - sin * q + push_p * x
        new_gq = cos * gq + sin * gp + push_q * g_force
        new_gp = cos * gp - sin * gq + push_p * g_force
        new_radius = total(decay.mag * radius, (t / (m * w)).mag * (force_e + e_force))
        z_r, v_r, v_next, _ = extent(new_q, new_p, new_gq, new_gp, new_radius)
        work_next = 0.5 * (y + np.abs(v_next.c) + v_r) + t * t * (K.mag * (y + t * a) + C.mag * a)
        work_next = total(work, np.minimum(u.c + u_r, max_n + e_force) * t * work_next)
        deepest = np.minimum(low, (new_q.c - z_r) - t * t * a * UP)
        lifts = (new_q.c + z_r >= -t * t * a / 8.0) & (v_hi >= 0.0)  # within the tick, too
        if (on & ((lifts & (v_lo <= 0.15)) | (deepest <= -body["rest_length_m"]))).any():
            raise RefusedError("a cell has no clear lift-off, or its leg has no length left")
        begun = lifting | lifts
        end_state = new_q, new_p, f_next, new_gq, new_gp, gf + g_rate * t, new_radius, kappa_next
        end_state = (
            *end_state,
            begun,
            np.where(begun, total(drift, t * change), 0.0),
            deepest,
            work_next,
        )
        end_state = (
            *end_state,
            np.where(begun, np.minimum(slow, v_lo), np.inf),
            np.maximum(fast, v_hi),
        )
        start_state = q, p, f, gq, gp, gf, radius, kappa, lifting, drift, low, work, slow, fast
        state = [pick(on, *pair) for pair in zip(end_state, start_state, strict=True)]
        q, p, f, gq, gp, gf, radius, kappa, lifting, drift, low, work, slow, fast = state
        on = on & ~(lifts & (new_q.c - z_r >= 1e-12))
        if not on.any():
            break
    else:
        raise RefusedError("a cell does not leave the ground within 2 s")
    # Flight: all orbits are off the ground at a tick, z / v̄ after lift-off with the speed ℓ.
    z_r, v_r, v, gv = extent(q, p, gq, gp, radius)
    lift, g_lift, by = v - q * kappa, gv - gq * kappa, 1.0 / v.c
    lift_e = total(np.hypot(w.mag, (d + kappa).mag) * (1 + LIBM) * radius, drift, lift.r)
    off = np.maximum(1.0 / np.minimum(slow, v.c - v_r) - by, by - 1.0 / np.maximum(fast, v.c + v_r))
    off = off + by * 8 * U
    touch, g_touch = lift * 2.0 / g - q * by, g_lift * 2.0 / g - gq * by
    touch_e = total(2.0 / g * lift_e, (radius + q.r) * by, (np.abs(q.c) + z_r) * off, touch.r)
    touch_r = total(g_touch.mag.sum(0), touch_e)
    first = np.floor((touch.c - touch_r) / t - 1e-6)
    last = np.floor((touch.c + touch_r) / t + 1e-6) + 1.0
    if (first < 1.0).any():
        raise RefusedError("a flight is too short")
    ranges, start = [(zero + np.inf, zero - np.inf)] * 2, (f, gf)
    for j in range(int(last.max()) + 1):
        box = Box(f.c, total(gf.mag.sum(0), f.r), zero, zero + e_load)
        rate, window = law.feedback(box), (j >= first) & (j <= last)
        start = [
            pick(j <= first, end_state, start_state)
            for end_state, start_state in zip((f, gf), start, strict=True)
        ]
        windows = [
            (np.where(window, x.lo, np.inf), np.where(window, x.hi, -np.inf))
            for x in (rate.range + law.omega, box.around)
        ]
        ranges = [
            (np.minimum(x[0], y[0]), np.maximum(x[1], y[1]))
            for x, y in zip(ranges, windows, strict=True)
        ]
        slope = Ball(rate.by_phase.c) * t + 1.0
        error = rate.by_phase.r * box.phase_r + rate.by_load.mag * e_load + rate.centre.r
        f_next = Ball(f.c) + (Ball(rate.centre.c) + law.omega) * t
        f, gf = f_next.grown(t * error, slope.mag * f.r, e_phase), gf * slope
    (f, gf), rate, around = start, hull(*ranges[0]), hull(*ranges[1])
    ahead = Ball(touch.c) + 0.5 * t - Ball(first) * t
    image = f + ahead * rate.c
    image = image.grown((gf + g_touch * rate.c).mag.sum(0), np.abs(rate.c) * (touch_e + 0.5 * t))
    image = image.grown(rate.r * (ahead.mag + touch_r + t), e_phase * (last - first + 1.0))
    box = Box(around.c, around.r, zero, zero + e_load)
    u = law.force(box, law.feedback(box)).range.grown(e_force)
    lift = Ball(lift.c, total(g_lift.mag.sum(0), lift_e))
    v = lift.hi * 1.01 + 0.1
    push = u / m * Ball(1.0, e_mass)
    gains = np.maximum((push - g).hi + (C + K * t).mag * stretch * v * UP, 0.0)
    fast = lift.hi + t * np.maximum((g - push).hi, 0.0) * UP
    return (
        lift.lo - t * gains * UP,
        fast,
        image.lo,
        image.hi,
        lift.lo,
        lift.hi,
        low,
        total(work, u.mag * t * v),
    )


def bodies(body, errors, splits):
    """Yield bodies, and errors around them, that cover all masses and stiffnesses."""
    errors, places = dict(errors), range(1 - splits, splits, 2)
    ranges = {"mass": "mass_kg", "stiffness": "stiffness_n_per_m"}
    for part in ((x, y) for x in places for y in places):
        member, shares = dict(body), dict(errors)
        for (name, entry), place in zip(ranges.items(), part, strict=True):
            member[entry] = body[entry] * (1.0 + errors[name] * place / splits)
            shares[name] = errors[name] / splits / (1.0 - errors[name]) * (1.0 + 1e-9)
        yield member, shares


def numbers(x):
    """The numbers of nested JSON values, in their order."""
    parts = x.values() if isinstance(x, dict) else x
    return [y for part in parts for y in numbers(part)] if isinstance(x, dict | list) else [x]


def check(certificate, controller=None, cells_at_once=4096):
    """Return the claims that are proved; raise `RefusedError` unless the certificate is right."""
    if (certificate["format"], certificate["version"]) != ("tegotae certificate", 1):
        raise RefusedError("this is no certificate of version 1")
    body, weights = certificate["body"], certificate["law"]["weights"]
    packed = struct.pack(f"<{len(weights)}d", *weights)
    if hashlib.sha256(packed).hexdigest() != certificate["sha256"]:
        raise RefusedError("the weights are not those of the hash")
    if controller is not None and numbers(controller["weights"]) != weights:
        raise RefusedError("the weights are not those of the controller")
    ranks, grid, law = np.array(certificate["ranks"]), certificate["grid"], certificate["law"]
    rows, columns = ranks.shape
    edges = np.linspace(grid["least_m_per_s"], grid["most_m_per_s"], rows + 1)
    turn = np.linspace(0.0, TURN, columns + 1) + 1e-12 * (np.arange(columns + 1) == columns)
    i, j = np.nonzero(ranks >= 0)
    if not len(i) or edges[0] <= 0.0 or (np.diff(edges) <= 0.0).any():
        raise RefusedError("there is no cell, or no speed above zero")
    positive, errors = [*body.values(), law["tick_s"]], [*certificate["errors"].values()]
    unclear = max(certificate["errors"][name] for name in ("stiffness", "mass")) > 0.1
    if unclear or not (np.min(positive) > 0 <= np.min(errors) and ranks.dtype.kind == "i"):
        raise RefusedError("a number of the body, an error or a rank is out of range")
    if not np.isfinite([*weights, *positive, *errors, law["omega_rad_per_s"]]).all():
        raise RefusedError("a number is not finite")
    count, splits, nominal = len(i), certificate["splits"], Law(law, body)
    if type(splits) is not int or splits < 1:
        raise RefusedError("the ranges of mass and stiffness are not split into parts")
    parts = [
        hop(nominal, *member, (edges[x], edges[x + 1]), (turn[y], turn[y + 1]))
        for member in bodies(body, certificate["errors"], splits)
        for x, y in (
            (i[a : a + cells_at_once], j[a : a + cells_at_once])
            for a in range(0, count, cells_at_once)
        )
    ]
    i, j = (np.tile(x, splits * splits) for x in (i, j))
    v0, v1, p0, p1, lift0, lift1, low, work = (np.concatenate(x) for x in zip(*parts, strict=True))
    twice, turns = (
        np.concatenate([turn[:-1], turn[:-1] + TURN, turn + 2 * TURN]),
        np.floor(p0 / TURN),
    )
    v0, v1 = np.searchsorted(edges, v0, "right") - 1, np.searchsorted(edges, v1, "left") - 1
    p0 = np.searchsorted(twice, p0 - turns * TURN - 1e-9, "right") - 1
    p1 = np.searchsorted(twice, p1 - turns * TURN + 1e-9, "left") - 1
    for cell, rank in enumerate(ranks[i, j]):
        place = f"the image of cell {i[cell]}, {j[cell]} of rank {rank}"
        if v0[cell] < 0 or v1[cell] >= rows or p1[cell] - p0[cell] >= columns:
            raise RefusedError(f"{place} leaves the grid")
        met = ranks[v0[cell] : v1[cell] + 1].take(range(p0[cell], p1[cell] + 1), 1, mode="wrap")
        if met.min() < 0 or (rank != FREE and met.max() > max(rank - 1, 0)):
            raise RefusedError(f"{place} meets cells of ranks {met.min()} to {met.max()}")
    g, l0, lasting = (
        body["gravity_m_per_s2"],
        body["rest_length_m"],
        np.isin(ranks[i, j], (0, FREE)),
    )
    apex = l0 + lift0 * lift0 / (2.0 * g) - 1e-12, l0 + lift1 * lift1 / (2.0 * g) + 1e-12
    proved = {
        "apex_m": [apex[0].min(), apex[1].max()],
        "lasting_apex_m": [apex[0][lasting].min(), apex[1][lasting].max()],
        "least_height_m": [l0 + low.min() - 1e-12],
        "cot_inverse_m_per_j": [((apex[0] - l0) / work)[lasting].min() * (1.0 - 8 * U)],
    }
    for name, claim in certificate["claims"].items():
        bounds, claimed = proved.get(name, [np.nan]), np.ravel(claim)
        low, high = claimed[0] <= bounds[0], len(bounds) == 1 or claimed[-1] >= bounds[-1]
        if len(bounds) != len(claimed) or not (low and high):
            raise RefusedError(f"the claim {name} is {claim}, and {bounds} was proved")
    return {"cells": count, "core": int((ranks == 0).sum()), **proved}


def finite(text):
    if not np.isfinite(float(text)):
        raise RefusedError(f"{text} is not a finite number")
    return float(text)


if __name__ == "__main__":
    try:
        if len(sys.argv) not in (2, 3):
            raise RefusedError("give CERTIFICATE.json, and CONTROLLER.json to compare its weights")
        texts = [Path(path).read_text("utf-8") for path in sys.argv[1:]]
        proved = check(*(json.loads(x, parse_float=finite, parse_constant=finite) for x in texts))
    except RefusedError as reason:
        sys.exit(f"refused: {reason}")
    except Exception as error:  # whatever is wrong with a file, it proves nothing
        sys.exit(f"refused: this is no whole certificate ({type(error).__name__}: {error})")
    for item in proved.items():
        print(item[0], *np.ravel(item[1]))
    print("accepted")
