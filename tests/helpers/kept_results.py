"""Saved results of a hopper, a walker and a training on MuJoCo, for comparison.

    python tests/helpers/kept_results.py             # the largest differences from what is kept
    python tests/helpers/kept_results.py --renew     # keep what it does now

Kept are trajectories (of the hopper from before the core had any number of limbs; over horizons on
which rounding cannot grow), two generations of a training, an evaluation, and the table of a smoke
study; and of a walker in double precision, with weights and fitness of three generations on a
MuJoCo model, which XLA gives to the bit on the processor that they were kept on.
"""

import sys
import tempfile
from pathlib import Path

import tegotae  # noqa: F401 - first, for it sets JAX up
from places import TESTS

# isort: split
import numpy as np

from research.reproduction.plan import plan
from research.reproduction.unit import work
from tegotae import Rollout, Scenario, Timing
from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.simulation.schedules import Step
from tegotae.simulation.summaries import whole_trajectory
from tegotae.systems import controller_file
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import legged_system as system
from tegotae.training.algorithms import PGPE
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train

MODELS = ("V-reflex-w8", "V-both-w4", "VG-gFv-sector-w4", "ARGT-rFv-gFv-tphif-w8", "T-Fv")
CHANNELS = (
    *("height_m", "velocity_m_per_s", "phase_rad", "spring_force_n", "feedback_rad_per_s"),
    *("actuator_force_n", "ground_m", "energy_j", "impulse_ns", "work_absolute_j"),
    *("work_net_j", "climb_flight_m", "climb_m", "apex_time_s", "apex_height_m"),
    *("apex_phase_rad", "touchdown_time_s", "failed"),
)


def weights_of(name: str, lanes: int = 3) -> np.ndarray:
    """Weights that make the controller do something, [lanes, n_weights]."""
    n = recipe(name).controller().n_weights
    draw = np.random.default_rng(len(name) + n)
    return draw.uniform(0.5, 3.0, (lanes, 1)) if n == 1 else draw.normal(0.0, 1.0, (lanes, n))


def trajectories() -> dict[str, np.ndarray]:
    """Some lanes of some models over 3 s, a drop in the last, by model, dtype and channel."""
    result = {}
    scenario = Scenario(
        omega=np.array([4.0, 6.5, 8.0]),
        height_m=np.array([1.2, 1.3, 1.1]),
        phase_rad=np.array([0.0, 2.0, 4.0]),
        drop_m=np.array([0.0, 0.0, 0.2]),
        drop_time_s=np.array([np.inf, np.inf, 1.0]),
    )
    for name in MODELS:
        for dtype in ("float32", "float64"):
            rollout = Rollout(controller=recipe(name).controller(), timing=Timing(duration_s=3.0))
            path = rollout.run(weights_of(name), scenario, dtype=dtype)
            for channel in CHANNELS:
                result[f"{name}.{dtype}.{channel}"] = getattr(path, channel)[4::5]
    return result


def evaluation() -> dict[str, np.ndarray]:
    """All metrics of a short evaluation of the vanilla controller, [runs, episodes]."""
    protocol = Protocol(undisturbed_s=12.0, disturbed_s=12.0, offsets=(-1.0, 0.0))
    result = evaluate(recipe("V-sector-w8").controller(), [[1.5], [3.0]], 8.0, protocol=protocol)
    return {f"evaluation.{name}": values for name, values in result.episodes.items()}


def study() -> dict[str, np.ndarray]:
    """Weights, fitness and curves of a unit of the smoke study, and its episodes' CoT⁻¹."""
    (unit,) = plan("smoke", "ART*").units
    record = work(unit)
    result = {f"study.curves.{name}": values for name, values in record.curves.items()}
    result["study.weights"] = record.weights
    result["study.best_fitness"] = record.best_fitness
    result |= {f"study.episodes.{name}": values for name, values in record.episodes.items()}
    return result


OF_LEGS = (
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
    return {f"walker.{name}": np.asarray(getattr(path, name)) for name in OF_LEGS}


def mujoco_training() -> dict[str, np.ndarray]:
    """Weights, fitness and curve of three generations of a feedback on the MuJoCo hopper."""
    from tegotae.envs import load_wiring
    from tegotae.envs.env_spec import EnvSpec

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


def hopper() -> dict[str, np.ndarray]:
    """All that is kept of the hopper, as it is now."""
    assert recipe("ART").name == "ART-rF-tphif-w8"
    return {**trajectories(), **evaluation(), **study()}


def loops() -> dict[str, np.ndarray]:
    """All that is kept of the walker and of MuJoCo, as it is now."""
    return {**walker(), **mujoco_training()}


def kept(name: str) -> dict[str, np.ndarray]:
    """All that is kept of `hopper` or `loops`."""
    with np.load(TESTS / "kept" / f"{name}.npz") as stored:
        return {name: stored[name] for name in stored.files}


def difference(previous: np.ndarray, updated: np.ndarray) -> float:
    """The largest one; infinite where one is NaN and the other is not."""
    a, b = np.asarray(previous, float), np.asarray(updated, float)
    if a.shape != b.shape or (np.isfinite(a) != np.isfinite(b)).any():
        return float("inf")
    return float(np.abs(np.where(np.isfinite(a), a - b, 0.0)).max(initial=0.0))


if __name__ == "__main__":
    for results in (hopper, loops):
        name, found = results.__name__, results()
        if "--renew" in sys.argv:
            np.savez_compressed(TESTS / "kept" / f"{name}.npz", allow_pickle=False, **found)
            continue
        gaps = {entry: difference(values, found[entry]) for entry, values in kept(name).items()}
        unequal = {entry: gap for entry, gap in gaps.items() if gap > 0.0}
        print(f"{name}: {len(gaps) - len(unequal)} of {len(gaps)} arrays are equal to the bit")
        for entry, gap in sorted(unequal.items(), key=lambda item: -item[1])[:20]:
            print(f"{entry}: {gap:.3g}")
