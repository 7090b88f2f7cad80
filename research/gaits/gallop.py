"""Explain why quadruped G gallops and where, and test if a gallop is ever faster or cheaper.

    python -m research.gaits.gallop everything
    python -m research.gaits.gallop modes   # which mode is light at which frequency; seconds
    python -m research.gaits.gallop map     # gaits over r and place of the mass; half a minute
    python -m research.gaits.gallop search  # gallops beside trots, bodies like G; two minutes
    python -m research.gaits.gallop best    # the best of these over all frequencies; seconds
    python -m research.gaits.gallop figure  # the figure of modes and map
    python -m research.gaits.gallop film    # walk, trot and gallop of one rollout; half a minute

Tables and the figure go to `docs/_static/gaits`. r is ω over the natural rate of pitching with all
feet down, ω / √(Σ K_z x_i² / I_yy), with x_i the hips' distance from the centre of mass.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D

from research.frame import main, write_rows
from tegotae._support.errors import TegotaeError
from tegotae._support.progress import reporting
from tegotae._support.tables import parse_numbers, read_csv
from tegotae.analysis.gaits.sweep import DETUNING, LevelsSummary, staircase_timing
from tegotae.figures.animation import FRAMES_PER_S, save_animation
from tegotae.figures.gaits.animation import moving
from tegotae.figures.gaits.style import gait_colour
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.gaits.names import NO_GAIT, gait_of, nearest_pattern
from tegotae.parts.bodies import Walker
from tegotae.parts.fields import replace
from tegotae.simulation.recorder import needing
from tegotae.simulation.rollout import Timing
from tegotae.simulation.schedules import Staircase
from tegotae.simulation.world import with_changes
from tegotae.systems.legged import Legged, lanes_of, random_phases
from tegotae.systems.tuned import front_family
from tegotae.systems.vanilla import legged_named

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "_static" / "gaits"
GALLOPS = ("rotary gallop", "transverse gallop", "canter")
OMEGAS = np.arange(3.0, 8.01, 0.25)
"""Frequencies at which modes are measured [√(g / l0)]."""
LAGS = 64
"""Random lags at each."""
MODES = {
    "heave": (1, 1, 1, 1), "pitch": (1, 1, -1, -1), "roll": (1, -1, 1, -1), "twist": (1, -1, -1, 1),
}  # fmt: skip
"""Signs of the modes at left fore, right fore, left hind, right hind."""


def pitch_rate(body: Walker) -> float:
    """Return the natural rate of pitching with all feet down, √(Σ K_z x_i² / I_yy) [√(g / l0)]."""
    arms = np.array(body.hips_x_m) - body.com_x_m
    return float(np.sqrt(body.stiffness_z_n_per_m * (arms**2).sum() / body.inertia_y_kg_m2))


# Modes


@needing("spring_force_n", "phase_rad", "time_s", "failed")
def harmonics(trajectory: Any, scenario: Any, body: Any, timing: Timing) -> Any:
    """Return ⟨N cos φ⟩ and ⟨N sin φ⟩ of every leg over the last whole strides, and its last
    phase.
    """
    t = trajectory
    stride = 2.0 * jnp.pi / scenario.omega
    span = jnp.floor(0.5 * timing.duration_s / stride) * stride
    count = (t.time_s[-1] - t.time_s < span).astype(t.time_s.dtype)[:, None]

    def mean(x: Any) -> Any:
        return (count * x).sum(axis=0) / count.sum(axis=0)

    load, phase = t.spring_force_n, t.phase_rad
    return mean(load * jnp.cos(phase)), mean(load * jnp.sin(phase)), phase[-1], t.failed[-1]


def coupling(legged: Legged) -> list[dict[str, Any]]:
    """Compute the coupling of a body's legs through their steps, by mode, at every frequency.

    Legs turn at ω without feedback, at random lags. To first order in σ the phases then obey

        φ̇_i = ω - σ ⟨N_i cos φ_i⟩ = ω - ½ σ Re Σ_j G_ij exp(i (φ_j - φ_i)),

    with G fitted to the loads. Its imaginary part on the pattern of a mode, κ = uᵀ Im G u, draws
    the legs towards this pattern if it is positive, and away from it if it is negative.
    """
    still = dataclasses.replace(legged, weights=(0.0,))
    phase = np.tile(random_phases(4, LAGS), len(OMEGAS))
    scenario = still.scenario(phase)._replace(omega=np.repeat(OMEGAS, LAGS))
    tick = legged.timing.tick_s
    timing = Timing(duration_s=60.0, tick_s=tick, frame_s=5.0 * tick)
    cosine, sine, last, fell = still.rollout(harmonics, timing).run((0.0,), scenario, legged.body)
    rows = []
    for k, omega in enumerate(OMEGAS):
        lanes = np.arange(k * LAGS, (k + 1) * LAGS)
        lanes = lanes[~fell[lanes].astype(bool)]
        matrix, explained = fitted((cosine - 1j * sine)[:, lanes], last[:, lanes])
        rows.append(
            {
                "omega": omega,
                "r": omega / pitch_rate(legged.body),  # type: ignore[arg-type]
                **{
                    f"kappa_{name}": 0.25 * np.real(np.array(u) @ matrix.imag @ np.array(u))
                    for name, u in MODES.items()
                },
                "explained": explained,
                "averaged_gait": averaged(matrix, legged),
            }
        )
    return rows


def fitted(loads: np.ndarray, phase: np.ndarray) -> tuple[np.ndarray, float]:
    """Fit G of ⟨N_i exp(-i φ_i)⟩ = ½ Σ_j G_ij exp(i (φ_j - φ_i)); return it and the share that it
    explains.
    """
    matrix, residual, total = np.zeros((4, 4), complex), 0.0, 0.0
    for i in range(4):
        phasors = np.exp(1j * (phase - phase[i])).T
        row, *_ = np.linalg.lstsq(phasors, loads[i], rcond=None)
        matrix[i] = 2.0 * row
        residual += np.abs(loads[i] - phasors @ row).var()
        total += np.abs(loads[i] - loads[i].mean()).var()
    return matrix, 1.0 - residual / total


def averaged(matrix: np.ndarray, legged: Legged) -> str:
    """Return the gait in which most of 64 random starts of the averaged equations end."""
    phase = random_phases(4, 64, 1)
    for _ in range(5000):
        phasors = np.exp(1j * (phase[None] - phase[:, None]))
        phase = phase - 0.05 * np.real((matrix[:, :, None] * phasors).sum(axis=1))
    lag = (phase[legged.reference] - phase) / (2.0 * np.pi) % 1.0
    names, counts = np.unique(nearest_pattern(lag, legged.names), return_counts=True)
    return str(names[counts.argmax()])


def emerged(legged: Legged) -> list[dict[str, Any]]:
    """Return the gait of 12 random starts with feedback at every frequency."""
    starts = 12
    phase = np.tile(random_phases(4, starts), len(OMEGAS))
    scenario = legged.scenario(phase)._replace(omega=np.repeat(OMEGAS, starts))
    results = lanes_of(legged.run(legged.summary(), scenario))
    gait = gait_of(results, legged.names).reshape(len(OMEGAS), starts)
    rows = []
    for k, names in enumerate(gait):
        name, count = commonest(names)
        lanes = np.arange(k * starts, (k + 1) * starts)[names == name]
        rows.append(
            {
                "gait": name,
                "starts": count,
                **{
                    column: np.mean(np.asarray(getattr(results, column))[..., lanes])
                    for column in _OF_GAIT
                },
            }
        )
    return rows


_OF_GAIT = ("speed_m_per_s", "cost_of_transport", "duty_factor", "flight_share", "lock_time_s")


def commonest(names: np.ndarray) -> tuple[str, int]:
    """Return the most common name, and how often it occurs."""
    gaits, counts = np.unique(names, return_counts=True)
    return str(gaits[counts.argmax()]), int(counts.max())


def modes() -> None:
    """Write `gallop-modes.csv`."""
    legged = legged_named("quadruped-g")
    rows = [a | b for a, b in zip(coupling(legged), emerged(legged), strict=True)]
    write_rows(FOLDER / "gallop-modes.csv", rows, digits=4)


# Bodies


def released(
    legged: Legged, bodies: dict[str, np.ndarray], tuned: dict[str, np.ndarray], starts: int
) -> Any:
    """Return the coordination of bodies with different numbers, from the same random releases.

    Args:
        legged: the system.
        bodies: fields of the body, [bodies] or [limbs, bodies].
        tuned: frequency, gain and ellipse, [bodies].
        starts: releases of each.
    """
    kind = front_family(legged, "vanilla ellipse")
    lanes = {name: np.repeat(x, starts) for name, x in tuned.items()}
    changes = {name: np.repeat(x, starts, axis=-1) for name, x in bodies.items()}
    count = len(lanes["omega"])
    scenario = kind.scenario(legged, lanes, np.tile(random_phases(4, starts), count // starts))
    body = legged.body
    sag = 0.25 / np.asarray(changes.get("stiffness_z_n_per_m", body.stiffness_z_n_per_m))  # type: ignore[attr-defined]
    com = np.asarray(changes.get("com_z_m", body.com_z_m))  # type: ignore[attr-defined]
    scenario = scenario._replace(height_m=np.broadcast_to(1.0 + com - sag + lanes["press"], count))
    own_system = dataclasses.replace(legged.system, controller=kind.controller(legged))
    base = legged.timing
    timing = Timing(duration_s=150.0, tick_s=base.tick_s, frame_s=2.0 * base.frame_s)
    rollout = own_system.rollout(legged.summary(), timing)
    return lanes_of(rollout.run(kind.weights(lanes), with_changes(scenario, body, changes), body))


def own_numbers(legged: Legged, omega: np.ndarray) -> dict[str, np.ndarray]:
    """Return the system's gain and ellipse at frequencies."""
    return front_family(legged, "vanilla ellipse").numbers(legged, {"omega": omega})


R, COM_X = np.linspace(0.2, 0.8, 16), np.linspace(-0.3, 0.3, 13)


def mapped() -> None:
    """Write `gallop-map.csv`: gaits over r and com_x, r by ω or by the inertia of pitching."""
    legged, starts, rows = legged_named("quadruped-g"), 4, []
    body: Any = legged.body
    r, com = (x.ravel() for x in np.meshgrid(R, COM_X, indexing="ij"))
    arms = np.array(body.hips_x_m)[:, None] - com
    stiff = body.stiffness_z_n_per_m * (arms**2).sum(axis=0)
    by_omega = r * np.sqrt(stiff / body.inertia_y_kg_m2)
    omega = 7.2
    inertia = stiff * (r / omega) ** 2
    yaw = body.inertia_z_kg_m2 / body.inertia_y_kg_m2
    axes = {
        "omega": ({"com_x_m": com}, by_omega),
        "inertia": (
            {"com_x_m": com, "inertia_y_kg_m2": inertia, "inertia_z_kg_m2": yaw * inertia},
            np.full_like(r, omega),
        ),
    }
    for axis, (bodies, omegas) in axes.items():
        able = possible(legged, bodies)
        bodies = {name: x[..., able] for name, x in bodies.items()}
        results = released(legged, bodies, own_numbers(legged, omegas[able]), starts)
        gait = gait_of(results, legged.names).reshape(-1, starts)
        speed, cost = (
            np.asarray(x).reshape(-1, starts)
            for x in (results.speed_m_per_s, results.cost_of_transport)
        )
        for k, names in enumerate(gait):
            name, count = commonest(names)
            matches = names == name
            rows.append(
                {
                    "by": axis, "r": r[able][k], "com_x": com[able][k], "omega": omegas[able][k],
                    "gait": name, "starts": count,
                    "speed_m_per_s": speed[k][matches].mean(),
                    "cost_of_transport": cost[k][matches].mean(),
                }
            )  # fmt: skip
    write_rows(FOLDER / "gallop-map.csv", rows, digits=4)


def possible(legged: Legged, bodies: dict[str, np.ndarray]) -> np.ndarray:
    """Return the numbers of those bodies that are possible, at the system's tick."""
    able = []
    for k in range(next(iter(bodies.values())).shape[-1]):
        fields = {
            name: tuple(x[:, k].tolist()) if x.ndim > 1 else float(x[k])
            for name, x in bodies.items()
        }
        try:
            replace(legged.body, fields).check_tick(legged.timing.tick_s)
        except TegotaeError:
            continue
        able.append(k)
    return np.array(able, int)


# A gallop that pays

LADDER = np.geomspace(2.0, 10.0, 12)
"""Frequencies of every body of the search [√(g / l0)]."""
VARIED = (
    "inertia_x_kg_m2", "inertia_y_kg_m2", "inertia_z_kg_m2", "stiffness_x_n_per_m",
    "stiffness_y_n_per_m", "stiffness_z_n_per_m", "damping_xy_ns_per_m", "damping_z_ns_per_m",
    "friction",
)  # fmt: skip
OF_FOOT = ("sigma", "stride", "lift", "press")


def drawn(count: int, around: dict[str, np.ndarray], width: float, draw: Any) -> dict:
    """Return bodies with numbers near those of some others, each varied by a factor or a length."""
    parents = draw.integers(len(around["com_x_m"]), size=count)
    bodies = {}
    for name, x in around.items():
        value = x[parents]
        if name in ("com_x_m", "com_z_m", "shift"):
            bodies[name] = value + width * (0.5 if name == "com_x_m" else 0.3) * draw.normal(
                size=count
            )
        else:
            bodies[name] = value * np.exp(width * draw.normal(size=count))
    bodies["com_z_m"] = np.clip(bodies["com_z_m"], -0.7, 0.0)
    roll, pitch, yaw = (bodies[f"inertia_{axis}_kg_m2"] for axis in "xyz")
    bodies["inertia_z_kg_m2"] = np.clip(yaw, np.abs(pitch - roll), pitch + roll)
    return bodies


def outcome(legged: Legged, drawn_bodies: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Compare the best gallop of every body over the ladder with the trot at a lower frequency.

    Returns:
        `faster`: the gallop's speed over that of the fastest trot at a lower frequency; `cheaper`:
        the cost of the cheapest trot at a lower frequency and not much slower (0.9), over the
        gallop's; NaN without a gallop and a trot below it, [bodies].
    """
    bodies = {name: drawn_bodies[name] for name in (*VARIED, "com_x_m", "com_z_m")}
    for name, axis in (("hips_x_m", "reach"), ("hips_y_m", "breadth")):
        signs = np.sign(np.array(getattr(legged.body, name)))
        bodies[name] = signs[:, None] * drawn_bodies[axis]
    able = possible(legged, bodies)
    rungs, starts, n = len(LADDER), 2, len(able)
    bodies = {name: np.repeat(x[..., able], rungs, axis=-1) for name, x in bodies.items()}
    tuned = own_numbers(legged, np.tile(LADDER, n))
    for name in (*OF_FOOT, "shift"):
        tuned[name] = np.repeat(drawn_bodies[name][able], rungs)
    results = released(legged, bodies, tuned, starts)
    gait = gait_of(results, legged.names).reshape(n, rungs, starts)
    speed, cost = (
        np.asarray(x).reshape(n, rungs, starts).mean(axis=2)
        for x in (results.speed_m_per_s, results.cost_of_transport)
    )
    gallops = np.isin(gait, GALLOPS).all(axis=2) & (speed > 0.05)
    trots = (gait == "trot").all(axis=2) & (speed > 0.05)
    result = {
        name: np.full(len(drawn_bodies["com_x_m"]), np.nan)
        for name in (
            "faster",
            "cheaper",
            "omega",
            "gallop_speed",
            "gallop_cost",
            "trot_speed",
            "trot_cost",
        )
    }
    result["gallop"] = np.full(len(drawn_bodies["com_x_m"]), "", object)
    for k, body in enumerate(able):
        for rung in np.flatnonzero(gallops[k]):
            below = np.flatnonzero(trots[k, :rung])
            if not len(below):
                continue
            fast = below[speed[k, below].argmax()]
            faster = speed[k, rung] / speed[k, fast]
            # At equal speed: a trot that is slower by much is not held against the gallop.
            near = below[speed[k, below] >= 0.9 * speed[k, rung]]
            cheaper = cost[k, near].min() / cost[k, rung] if len(near) else np.nan
            against = near[cost[k, near].argmin()] if len(near) else fast
            score = max(faster, 0.0 if np.isnan(cheaper) else cheaper)
            previous = np.nanmax([result["faster"][body], result["cheaper"][body], 0.0])
            if score > previous:
                result["faster"][body], result["cheaper"][body] = faster, cheaper
                result["omega"][body] = LADDER[rung]
                result["gallop_speed"][body], result["gallop_cost"][body] = (
                    speed[k, rung],
                    cost[k, rung],
                )
                result["trot_speed"][body], result["trot_cost"][body] = (
                    speed[k, against],
                    cost[k, against],
                )
                result["gallop"][body] = commonest(gait[k, rung])[0]
    return result


def of_system(legged: Legged) -> dict[str, np.ndarray]:
    """Return the numbers of a system's body and foot as those of one body of the search."""
    body: Any = legged.body
    values = {name: np.array([getattr(body, name)]) for name in (*VARIED, "com_x_m", "com_z_m")}
    values |= {"reach": np.array([body.hips_x_m[0]]), "breadth": np.array([body.hips_y_m[0]])}
    foot = own_numbers(legged, np.ones(1))
    return values | {name: foot[name] for name in (*OF_FOOT, "shift")}


def search(count: int = 512, rounds: int = 4) -> None:
    """Write `gallop-search.csv`: the bodies whose gallop does best beside the trot below it."""
    legged = legged_named("quadruped-g")
    draw = np.random.default_rng(0)
    archive: dict[str, np.ndarray] = {}
    around = of_system(legged)
    with reporting("bodies", count * rounds) as reporter:
        for number in range(rounds):
            bodies = drawn(count, around, (0.3, 0.3, 0.2, 0.12)[min(number, 3)], draw)
            candidates = bodies | outcome(legged, bodies)
            archive = {
                k: np.concatenate([archive[k], x]) if archive else x for k, x in candidates.items()
            }
            reporter.update(count * (number + 1))
            score = np.fmax(archive["faster"], np.nan_to_num(archive["cheaper"]))
            first = np.argsort(-np.nan_to_num(score))[:16]
            first = first[np.nan_to_num(score[first]) > 0.0]
            if len(first):
                around = {name: archive[name][first] for name in around}
    order = np.argsort(
        -np.nan_to_num(np.fmax(archive["faster"], np.nan_to_num(archive["cheaper"])))
    )
    rows = [{name: x[k] for name, x in archive.items()} for k in order[:20]]
    write_rows(FOLDER / "gallop-search.csv", rows, digits=5)
    has = np.isfinite(archive["faster"])
    print(f"{len(has)} bodies, {has.sum()} with a gallop and a trot below it")
    print(
        f"faster: {(archive['faster'][has] > 1).sum()}, "
        f"cheaper: {(archive['cheaper'][has] > 1).sum()}"
    )


def best() -> None:
    """Write `gallop-best.csv`: the gaits over ω of the body whose gallop beats its trots most.

    It beats them in speed and in cost: of the rows of the search whose gallop costs less than the
    fastest trot below it, the one that is faster by most.
    """
    legged, starts = legged_named("quadruped-g"), 8
    table = read_csv(FOLDER / "gallop-search.csv")
    columns = {name: parse_numbers(x) for name, x in table.items() if name != "gallop"}
    pays = columns["gallop_cost"] < columns["trot_cost"]
    # A trot that hardly moves is no rival.
    pays &= columns["trot_speed"] > 0.2
    k = int(np.argmax(np.where(pays, columns["faster"], 0.0)))
    omegas = np.linspace(2.0, 11.0, 37)
    values = {name: columns[name][k] for name in (*VARIED, "com_x_m", "com_z_m")}
    bodies = {name: np.full(len(omegas), x) for name, x in values.items()}
    for name, axis in (("hips_x_m", "reach"), ("hips_y_m", "breadth")):
        signs = np.sign(np.array(getattr(legged.body, name)))
        bodies[name] = signs[:, None] * np.full(len(omegas), columns[axis][k])
    tuned = own_numbers(legged, omegas)
    tuned |= {name: np.full(len(omegas), columns[name][k]) for name in (*OF_FOOT, "shift")}
    results = released(legged, bodies, tuned, starts)
    gait = gait_of(results, legged.names).reshape(-1, starts)
    rows = []
    for index, omega in enumerate(omegas):
        name, count = commonest(gait[index])
        lanes = index * starts + np.flatnonzero(gait[index] == name)
        rows.append(
            {"omega": omega, "gait": name, "starts": count}
            | {
                column: np.mean(np.asarray(getattr(results, column))[..., lanes])
                for column in _OF_GAIT
            }
        )
    write_rows(FOLDER / "gallop-best.csv", rows, digits=4)


# Figure


def drawn_figure() -> None:
    """Write `gallop.png` of the kept tables: the modes over ω, and the two maps."""
    with styled():
        figure = new_figure(PAGE_IN, 2.9)
        panel, *maps = figure.subplots(1, 3, width_ratios=(1.1, 1.0, 1.0))
        _modes(panel)
        names: list[str] = []
        table = read_csv(FOLDER / "gallop-map.csv")
        for axes, axis, title in zip(maps, ("omega", "inertia"), _TITLES, strict=True):
            names += _map(axes, table, axis)
            axes.set(xlabel="centre of mass, forward [l0]", title=title)
        maps[0].set_ylabel("ω over the rate of pitching, r")
        named_gaits = sorted(set(names), key=lambda name: (name in NO_GAIT, name))
        keys = [
            Line2D([], [], marker="s", ls="", color=gait_colour(n), label=n) for n in named_gaits
        ]
        figure.legend(handles=keys, loc="outside lower center", ncols=5)
        save_figure(figure, FOLDER / "gallop.png")


RISE = (3.4, 5.5, 7.6)
"""Frequencies of the film, one after the other without a new release: walk, trot, gallop."""
DWELL, SHOWN = 200.0, 3.0
"""Duration of each frequency [√(l0 / g)], and the number of its last strides that are shown, one a
second."""


def risen() -> tuple[Legged, Any, list[str], list[Any], Timing]:
    """Simulate one rollout in which ω rises by steps; return system, trajectory, and the gait of
    each level."""
    legged = legged_named("quadruped-g")
    timing = staircase_timing(legged.timing, len(RISE), DWELL)
    phase = random_phases(4, 1)
    off = DETUNING * np.random.default_rng(0).normal(size=phase.shape)
    climb = Staircase(np.array([RISE[1] - RISE[0]]), timing.duration_s / len(RISE), len(RISE) + 0.0)
    scenario = legged.scenario(phase, changes={"omega": climb})._replace(omega=RISE[0] * (1 + off))
    levels = legged.summary(LevelsSummary, levels=len(RISE))

    def closely(trajectory: Any, scenario: Any, body: Any, timing: Timing) -> Any:
        return trajectory, levels(trajectory, scenario, body, timing)

    trajectory, result = legged.run(closely, scenario, timing)
    trajectory = jax.tree.map(lambda x: np.asarray(x)[..., 0], trajectory)
    result = lanes_of(result)
    results = [type(result)(*(x[k] for x in result)) for k in range(len(RISE))]
    gaits = [gait_of(level, legged.names)[0] for level in results]
    return legged, trajectory, gaits, results, timing


def film() -> None:
    """Write `transition.gif`: one rollout in which ω rises by steps."""
    legged, trajectory, gaits, levels, timing = risen()
    length = timing.n_frames // len(RISE)
    frames = []
    for k, level in enumerate(levels):
        back_s = SHOWN / float(level.cycle_frequency_hz[0])
        back = np.linspace(back_s / timing.frame_s, 0.0, round(SHOWN * FRAMES_PER_S))
        frames.append((k + 1) * length - 1 - np.round(back).astype(int))
    with styled():
        animation = moving(
            legged,
            trajectory,
            np.concatenate(frames),
            lambda frame: f"ω = {RISE[frame // length]:g}   {gaits[frame // length]}",
        )
        save_animation(animation, FOLDER / "transition.gif")
    print(*(f"ω = {w:g}: {gait}" for w, gait in zip(RISE, gaits, strict=True)), sep="; ")


_TITLES = ("r varied by ω", "r varied by inertia, ω = 7.2")


def _modes(axes: Axes) -> None:
    table = read_csv(FOLDER / "gallop-modes.csv")
    omega = parse_numbers(table["omega"])
    for k, name in enumerate(MODES):
        axes.plot(omega, parse_numbers(table[f"kappa_{name}"]), color=COLOURS[k], label=name)
    axes.axhline(0.0, color="0.6", lw=0.6)
    low = -0.34
    for w, gait in zip(omega, table["gait"], strict=True):
        axes.bar(w, 0.04, 0.25, low, color=gait_colour(str(gait)), lw=0)
    axes.set(xlabel="frequency ω [√(g/l0)]", ylabel="κ [m g]", ylim=(low, 0.5))
    axes.legend(loc="upper left", ncols=2)
    axes.set_title("modes; below, the gait")


def _map(axes: Axes, table: dict[str, np.ndarray], axis: str) -> list[str]:
    rows = table["by"] == axis
    x, y = parse_numbers(table["com_x"][rows]), parse_numbers(table["r"][rows])
    gaits = [str(name) for name in table["gait"][rows]]
    share = parse_numbers(table["starts"][rows]) / 4.0
    colours = [to_rgba(gait_colour(gait), float(s)) for gait, s in zip(gaits, share, strict=True)]
    width, height = COM_X[1] - COM_X[0], R[1] - R[0]
    axes.bar(x, height, width, y - 0.5 * height, color=colours, lw=0)
    return gaits


def everything() -> None:
    """Measure all tables, and draw the figure and the film."""
    for step in (modes, mapped, search, best, drawn_figure, film):
        step()


if __name__ == "__main__":
    main(everything, modes, search, best, film, map=mapped, figure=drawn_figure)
