"""Saved trajectories of the hopper from before the core had any number of limbs, for comparison.

    python tests/helpers/kept_hopper.py             # the largest differences from what is kept
    python tests/helpers/kept_hopper.py --renew     # keep what it does now

Kept are trajectories (over horizons on which rounding cannot grow), two generations of a training,
an evaluation, and the table of a smoke study.
"""

import sys

import tegotae  # noqa: F401 - first, for it sets JAX up
from places import TESTS

# isort: split
import numpy as np

from research.reproduction.plan import plan
from research.reproduction.unit import work
from tegotae import Rollout, Scenario, Timing
from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.systems.recipe import recipe

KEPT = TESTS / "kept" / "hopper.npz"

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


def now() -> dict[str, np.ndarray]:
    """All that is kept, as it is now."""
    assert recipe("ART").name == "ART-rF-tphif-w8"
    return {**trajectories(), **evaluation(), **study()}


def kept() -> dict[str, np.ndarray]:
    """All that is kept."""
    with np.load(KEPT) as stored:
        return {name: stored[name] for name in stored.files}


def difference(previous: np.ndarray, updated: np.ndarray) -> float:
    """The largest one; infinite where one is NaN and the other is not."""
    a, b = np.asarray(previous, float), np.asarray(updated, float)
    if a.shape != b.shape or (np.isfinite(a) != np.isfinite(b)).any():
        return float("inf")
    return float(np.abs(np.where(np.isfinite(a), a - b, 0.0)).max(initial=0.0))


if __name__ == "__main__":
    found = now()
    if "--renew" in sys.argv:
        KEPT.parent.mkdir(exist_ok=True)
        np.savez_compressed(KEPT, allow_pickle=False, **found)
        sys.exit(f"{KEPT}: {KEPT.stat().st_size / 1024:.0f} KiB")
    gaps = {name: difference(values, found[name]) for name, values in kept().items()}
    unequal = {name: gap for name, gap in gaps.items() if gap > 0.0}
    print(f"{len(gaps) - len(unequal)} of {len(gaps)} arrays are equal to the bit")
    for name, gap in sorted(unequal.items(), key=lambda item: -item[1])[:20]:
        print(f"{name}: {gap:.3g}")
