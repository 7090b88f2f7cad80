"""Saved results of a walker and of a training on MuJoCo, for comparison.

    python tests/helpers/kept_loops.py             # the largest differences from what is kept
    python tests/helpers/kept_loops.py --renew     # keep what it does now

Kept are trajectories of a walker in double precision, over a horizon on which rounding cannot grow,
and weights and fitness of three generations on a MuJoCo model. On the processor that they were kept
on, XLA gives them to the bit; on others the last digits differ.
"""

import sys
import tempfile
from pathlib import Path

import tegotae  # noqa: F401 - first, for it sets JAX up
from places import TESTS

# isort: split
import numpy as np

from kept_hopper import difference
from tegotae import Timing
from tegotae.envs import load_wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.simulation.schedules import Step
from tegotae.simulation.summaries import whole_trajectory
from tegotae.systems import controller_file
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import legged_system as system
from tegotae.training.algorithms import PGPE
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train

KEPT = TESTS / "kept" / "loops.npz"

CHANNELS = (
    *("height_m", "velocity_m_per_s", "phase_rad", "spring_force_n", "feedback_rad_per_s"),
    *("x_m", "y_m", "pitch_rad", "roll_rad", "yaw_rad", "energy_j", "impulse_ns"),
    *("work_absolute_j", "work_net_j", "climb_m", "touchdown_time_s", "failed"),
)

ALGORITHM = PGPE(population=4, std=0.3, std_lr=0.1, learning_rate=0.2, max_speed=0.4)


def walker() -> dict[str, np.ndarray]:
    """Four lanes of the quadruped over 4 √(l0/g): a drop, a lost leg, another mass, by channel."""
    legged = system("quadruped-c")
    drawn = np.random.default_rng(4).uniform(0.0, 2.0 * np.pi, (legged.body.limbs, 4))
    present = np.ones((legged.body.limbs, 4))
    present[0, 2] = 0.0
    scenario = legged.scenario(
        drawn,
        drop_m=np.array([0.0, 0.1, 0.0, 0.0]),
        drop_time_s=np.array([np.inf, 2.0, np.inf, np.inf]),
        changes={"present": Step(present, 2.0), "mass_kg": np.array([1.0, 1.0, 1.0, 1.3])},
    )
    timing = Timing(duration_s=4.0, tick_s=legged.timing.tick_s, frame_s=0.2)
    rollout = legged.rollout(whole_trajectory, timing)
    path = rollout.run(legged.weights, scenario, legged.body, dtype="float64")
    return {f"walker.{name}": np.asarray(getattr(path, name)) for name in CHANNELS}


def mujoco_training() -> dict[str, np.ndarray]:
    """Weights, fitness and curve of three generations of a feedback on the MuJoCo hopper."""
    experiment = EnvExperiment.from_recipe(
        recipe("AR"), EnvSpec(env="hopper"), load_wiring("hopper"), budget=12, duration_s=2.4
    )
    run = Run(
        experiment=experiment,
        seeds=(0, 1),
        learner=Evolution(algorithm=ALGORITHM, stopping=Stopping.after(3), workers=0),
    )
    with tempfile.TemporaryDirectory() as folder:
        saved = [controller_file.load(path) for path in train(run, Path(folder))]
        rows = (Path(folder) / "curves.csv").read_text().splitlines()
    header = rows[0].split(",")
    columns = dict(
        zip(header, zip(*(row.split(",") for row in rows[1:]), strict=True), strict=True)
    )
    result = {f"mujoco.curves.{n}": np.array(columns[n], float) for n in header if "fitness" in n}
    result["mujoco.weights"] = np.stack([entry.weights for entry in saved])
    result["mujoco.best_fitness"] = np.array([entry.training["best_fitness"] for entry in saved])
    return result


def now() -> dict[str, np.ndarray]:
    """All that is kept, as it is now."""
    return {**walker(), **mujoco_training()}


def kept() -> dict[str, np.ndarray]:
    """All that is kept."""
    with np.load(KEPT) as stored:
        return {name: stored[name] for name in stored.files}


if __name__ == "__main__":
    found = now()
    if "--renew" in sys.argv:
        np.savez_compressed(KEPT, allow_pickle=False, **found)
        sys.exit(f"{KEPT}: {KEPT.stat().st_size / 1024:.0f} KiB")
    gaps = {name: difference(values, found[name]) for name, values in kept().items()}
    unequal = {name: gap for name, gap in gaps.items() if gap > 0.0}
    print(f"{len(gaps) - len(unequal)} of {len(gaps)} arrays are equal to the bit")
    for name, gap in sorted(unequal.items(), key=lambda item: -item[1])[:20]:
        print(f"{name}: {gap:.3g}")
