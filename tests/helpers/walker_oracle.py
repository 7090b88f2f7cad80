"""The walking torso once more, for the tests: adaptive, float64, contacts located.

Written from the equations alone, in NumPy and SciPy; nothing of the package's physics is used. Each
leg is driven by vanilla Tegotae from its own load. Units: the leg's length, the torso's mass and
gravity are 1. The ground is flat, at height 0.

The state is one vector: place and velocity of the centre of mass, turn (quaternion, body to world),
turn rate in body axes, then for each leg its phase, its anchor's x and y, and what was summed up so
far: actuator work done and taken back, slip, and losses by damping, friction and release.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

MOST_SEGMENTS = 20_000


@dataclass(frozen=True, kw_only=True)
class Parts:
    """A torso on legs, and what drives them; numbers as in the specification of legs."""

    sigma: float
    stride: float
    lift: float
    press: float
    shift: float
    hips: tuple[tuple[float, float], ...]
    com_x: float = 0.0
    com_z: float
    inertia: tuple[float, float, float]
    stiffness: tuple[float, float, float]
    damping: tuple[float, float, float]
    friction: float

    @property
    def standing_height(self) -> float:
        """Height of the centre of mass over its four pressed feet."""
        return 1.0 + self.press + self.com_z - 1.0 / (len(self.hips) * self.stiffness[2])


def four(x: float, y: float) -> tuple[tuple[float, float], ...]:
    """Hips left fore, right fore, left hind, right hind."""
    return (x, y), (x, -y), (-x, y), (-x, -y)


def six(x: float, y: float) -> tuple[tuple[float, float], ...]:
    """The same with a pair of hips in the middle."""
    return (x, y), (x, -y), (0.0, y), (0.0, -y), (-x, y), (-x, -y)


SET_A = Parts(
    sigma=1.0,
    stride=0.25,
    lift=0.08,
    press=0.02,
    shift=0.0,
    hips=four(0.7, 0.45),
    com_z=-0.2,
    inertia=(0.10, 0.25, 0.30),
    stiffness=(15.0, 8.0, 8.0),
    damping=(1.5, 1.5, 1.2),
    friction=0.6,
)
SET_C = Parts(
    sigma=1.25,
    stride=0.2,
    lift=0.12,
    press=0.03,
    shift=0.4,
    hips=four(0.85, 0.44),
    com_z=-0.39,
    inertia=(0.10, 0.24, 0.29),
    stiffness=(10.0, 3.7, 14.0),
    damping=(1.3, 1.3, 0.9),
    friction=0.8,
)


@dataclass(frozen=True)
class Start:
    """Release of the torso; the feet are put down where they are commanded."""

    place: tuple[float, float, float]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    turn_rate: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Now:
    """All that the equations say of one state; vectors of legs are [legs, 3]."""

    rotation: np.ndarray
    command_height: np.ndarray
    spring: np.ndarray
    force: np.ndarray
    load: np.ndarray
    power: np.ndarray
    rate: np.ndarray


@dataclass
class Walk:
    """Recording of a walk: [times, ...]; and the times at which feet came down and went up."""

    times: np.ndarray
    state: np.ndarray
    load: np.ndarray
    contact: np.ndarray
    spring_energy: np.ndarray
    legs: int
    touchdowns: list[tuple[float, int]] = field(default_factory=list)
    liftoffs: list[tuple[float, int]] = field(default_factory=list)

    def _legs(self, column: int) -> np.ndarray:
        return self.state[:, 13 + column * self.legs : 13 + (column + 1) * self.legs]

    @property
    def place(self) -> np.ndarray:
        return self.state[:, 0:3]

    @property
    def velocity(self) -> np.ndarray:
        return self.state[:, 3:6]

    @property
    def turn(self) -> np.ndarray:
        return self.state[:, 6:10]

    @property
    def turn_rate(self) -> np.ndarray:
        return self.state[:, 10:13]

    @property
    def roll_pitch_yaw(self) -> np.ndarray:
        """Angles [times, 3] of R = Rz(yaw) Ry(pitch) Rx(roll)."""
        w, x, y, z = self.turn.T
        return np.stack(
            [
                np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
                np.arcsin(2 * (w * y - z * x)),
                np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
            ],
            axis=-1,
        )

    @property
    def phase(self) -> np.ndarray:
        return self._legs(0)

    @property
    def anchor(self) -> np.ndarray:
        """Places of the feet: [times, legs, 2]."""
        return np.stack([self._legs(1), self._legs(2)], axis=-1)

    @property
    def work_done(self) -> np.ndarray:
        """Work of each leg's actuator so far while its power was positive."""
        return self._legs(3)

    @property
    def work_taken(self) -> np.ndarray:
        """Work of each leg's actuator so far while its power was negative; this is ≤ 0."""
        return self._legs(4)

    @property
    def slip(self) -> np.ndarray:
        """Distance that each foot has slipped so far."""
        return self._legs(5)

    @property
    def damping_loss(self) -> np.ndarray:
        return self._legs(6)

    @property
    def friction_loss(self) -> np.ndarray:
        return self._legs(7)

    @property
    def release_loss(self) -> np.ndarray:
        """Energy of the springs of feet that left the ground."""
        return self._legs(8)

    def energy(self, parts: Parts) -> np.ndarray:
        """Energy of motion, of height, and of the springs of feet on the ground."""
        moving = 0.5 * (self.velocity**2).sum(1)
        turning = 0.5 * (np.array(parts.inertia) * self.turn_rate**2).sum(1)
        return moving + turning + self.place[:, 2] + self.spring_energy

    def cost_of_transport(self, first: int, last: int = -1) -> float:
        """Absolute work of all legs over distance between two of the times."""
        process = (self.work_done - self.work_taken).sum(1)
        distance = np.linalg.norm(self.place[last, :2] - self.place[first, :2])
        return (process[last] - process[first]) / distance


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return NumPy's cross product without its overhead, which is felt here."""
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=-1)


def rotation(turn: np.ndarray) -> np.ndarray:
    """Body to world, of a quaternion of any length."""
    w, x, y, z = turn / np.sqrt(turn @ turn)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def command(parts: Parts, phase: np.ndarray, lifting: np.ndarray) -> np.ndarray:
    """Return the commanded places of the feet, in body axes."""
    hips = np.array(parts.hips)
    height = np.where(lifting, parts.lift, parts.press)
    return np.stack(
        [
            hips[:, 0] - parts.com_x - parts.stride * np.cos(phase + parts.shift),
            hips[:, 1],
            -parts.com_z - 1.0 + height * np.sin(phase),
        ],
        axis=-1,
    )


def look(parts: Parts, omega, s: np.ndarray, contact: np.ndarray, lifting: np.ndarray) -> Now:
    """The equations. `contact`, `lifting`: which feet are down, and which phases have sin φ > 0."""
    n = len(parts.hips)
    inertia, k, c = map(np.array, (parts.inertia, parts.stiffness, parts.damping))
    p, v, turn, w = s[0:3], s[3:6], s[6:10], s[10:13]
    phase, anchor_x, anchor_y = s[13 : 13 + 3 * n].reshape(3, n)
    r = rotation(turn)
    foot = command(parts, phase, lifting)

    # Where a foot stands seen from the torso, and the spring between it and the command.
    arm = (np.stack([anchor_x, anchor_y, np.zeros(n)], axis=-1) - p) @ r
    d = np.where(contact[:, None], arm - foot, 0.0)
    load = np.maximum(0.0, k[2] * d[:, 2])
    phase_rate = omega - parts.sigma * load * np.cos(phase)
    swing = parts.stride * np.sin(phase + parts.shift)
    rise = np.where(lifting, parts.lift, parts.press) * np.cos(phase)
    foot_rate = np.stack([swing, np.zeros(n), rise], axis=-1) * phase_rate[:, None]
    arm_rate = -cross(w, arm) - v @ r
    d_rate = arm_rate - foot_rate

    # What spring and damper want, and what the ground gives.
    expected = np.where(contact[:, None], (k * d + c * d_rate) @ r.T, 0.0)
    normal = np.maximum(0.0, expected[:, 2])
    along = np.hypot(expected[:, 0], expected[:, 1])
    held = np.minimum(1.0, parts.friction * normal / np.maximum(along, 1e-300))
    force = np.column_stack([expected[:, :2] * held[:, None], normal])
    slip = (force[:, :2] - expected[:, :2]) / c[0]
    force_b = force @ r

    power = -(force_b * foot_rate).sum(1)
    moved = d_rate + np.column_stack([slip, np.zeros(n)]) @ r
    missing = ((force_b - k * d) * moved).sum(1)
    turned = np.concatenate([[-(turn[1:] @ w)], turn[0] * w + cross(turn[1:], w)]) * 0.5
    rate = np.concatenate(
        [
            v,
            force.sum(0) - (0.0, 0.0, 1.0),
            turned,
            (cross(arm, force_b).sum(0) - cross(w, inertia * w)) / inertia,
            phase_rate,
            slip[:, 0],
            slip[:, 1],
            np.maximum(power, 0.0),
            np.minimum(power, 0.0),
            np.hypot(slip[:, 0], slip[:, 1]),
            np.where(contact, missing, 0.0),
            -(force[:, :2] * slip).sum(1),
            np.zeros(n),
        ]
    )
    return Now(r, p[2] + foot @ r[2], 0.5 * (k * d * d).sum(1), force, load, power, rate)


def walk(
    parts: Parts,
    omega,
    start: Start,
    phases,
    times,
    *,
    rtol: float = 1e-9,
    atol: float = 1e-11,
    floor: bool = True,
) -> Walk:
    """Walk from a start and phases [legs], seen at increasing `times` ≥ 0; `floor=False`: fall."""
    n, times = len(parts.hips), np.asarray(times, float)
    phases = np.asarray(phases, float)
    lifting = np.sin(phases) > 0
    s = np.concatenate(
        [start.place, start.velocity, start.turn, start.turn_rate, phases, np.zeros(8 * n)]
    )
    nobody = np.zeros(n, bool)
    contact = floor & (look(parts, omega, s, nobody, lifting).command_height < 0)

    def follow(s, legs):
        """Feet that are not on the ground are where they are commanded."""
        foot = command(parts, s[13 : 13 + n], lifting) @ rotation(s[6:10]).T
        for leg in legs:
            s[13 + n + leg], s[13 + 2 * n + leg] = s[:2] + foot[leg, :2]

    follow(s, range(n))
    samples: list[tuple] = []
    touchdowns, liftoffs = [], []
    since = {"contact": np.full(n, -1.0), "lifting": np.full(n, -1.0)}
    t, end = 0.0, float(times[-1])
    if times[0] == 0.0:
        moment = look(parts, omega, s, contact, lifting)
        samples.append((s.copy(), moment.load, contact, moment.spring.sum()))

    for segment in itertools.count():
        if t >= end - 1e-12:
            break
        assert segment < MOST_SEGMENTS, f"contacts pile up at {t}"

        def rate(t, s, contact=contact, lifting=lifting):
            return look(parts, omega, s, contact, lifting).rate

        events = []
        for leg in range(n):

            def touches(t, s, leg=leg, lifting=lifting):
                height = parts.lift if lifting[leg] else parts.press
                x = parts.hips[leg][0] - parts.com_x
                x -= parts.stride * np.cos(s[13 + leg] + parts.shift)
                z = -parts.com_z - 1.0 + height * np.sin(s[13 + leg])
                return s[2] + rotation(s[6:10])[2] @ (x, parts.hips[leg][1], z)

            # Only what ends the present state of a leg, or rounding would find its start again.
            touches.terminal, touches.direction = True, 1 if contact[leg] else -1
            if floor:
                events.append((touches, "contact", leg))

            def turns(t, s, leg=leg):
                return np.sin(s[13 + leg])

            turns.terminal, turns.direction = True, -1 if lifting[leg] else 1
            events.append((turns, "lifting", leg))

        solved = solve_ivp(
            rate,
            (t, end),
            s,
            "DOP853",
            t_eval=times[(times > t) & (times <= end)],
            events=[event for event, _, _ in events],
            rtol=rtol,
            atol=atol,
            max_step=0.1,
            first_step=min(1e-4, end - t),  # a foot that hardly left is away before it comes back
        )
        assert solved.status >= 0, solved.message
        for state in map(np.copy, np.transpose(solved.y) if len(solved.t) else ()):
            follow(state, np.flatnonzero(~contact))
            moment = look(parts, omega, state, contact, lifting)
            samples.append((state, moment.load, contact, moment.spring.sum()))
        if solved.status == 0:
            break
        (hit,) = (i for i, result in enumerate(solved.t_events) if len(result))
        t, s = solved.t_events[hit][0], solved.y_events[hit][0].copy()
        contact, lifting = contact.copy(), lifting.copy()
        for i, (event, kind, leg) in enumerate(events):
            # Feet that move as one: the solver tells of one event, and the others are just past.
            past = event(t, s) * event.direction > 0 and t - since[kind][leg] > 1e-9
            if i != hit and not past:
                continue
            since[kind][leg] = t
            if kind == "lifting":
                lifting[leg] = ~lifting[leg]
            elif contact[leg]:
                s[13 + 8 * n + leg] += look(parts, omega, s, contact, lifting).spring[leg]
                contact[leg] = False
                liftoffs.append((t, leg))
            else:
                follow(s, [leg])
                contact[leg] = True
                touchdowns.append((t, leg))

    state, load, down, spring = map(np.array, zip(*samples, strict=True))
    return Walk(times, state, load, down, spring, n, touchdowns, liftoffs)
