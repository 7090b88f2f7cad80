"""Hashes of results, kept to show that a change of the code changes no number.

    python tests/helpers/pins.py             # which results differ from the kept ones
    python tests/helpers/pins.py --renew     # keep the hashes of the present results

A hash is of an array's type, shape and bytes, so it sees the last bit; an export's is of its text.
Versions, paths, dates and file formats have no part in it.

The bits depend on the code, and on little else. Native code gives the same ones on every processor
and under every setting of XLA. XLA makes the draws and updates of a training and the search for a
gain; a training amplifies their last digits until none is left to compare. Without the flags below
26 results differ, of the study and of trainings. So nothing is rounded: the flags are fixed, and
pins are compared only with the versions of the libraries in the file, on an x86-64 processor with
fused multiply-add, where AVX2 and AVX-512 give the same bits. Elsewhere they are left out; renew
them on the earlier code there, and compare the later code with that. `kept_results.py` compares
within tolerances, on any machine.
"""

import contextlib
import csv
import dataclasses
import hashlib
import importlib.util
import io
import json
import os
import platform
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

if __name__ == "__main__":  # before JAX is imported; programs compile fast, as in `make test`
    os.environ["XLA_FLAGS"] = (
        "--xla_backend_optimization_level=0 --xla_cpu_use_fusion_emitters=false"
    )
    os.environ["JAX_PLATFORMS"] = "cpu"
    os.environ.pop("TEGOTAE_ENGINE", None)

import tegotae  # noqa: F401 - first, for it sets JAX up
from places import TESTS

# isort: split
import llvmlite.binding as llvm
import numpy as np

import tiny
from research.reproduction.plan import plan
from tegotae import Hopper, System, Timing, cli
from tegotae.analysis.gaits.map import Axis, map_gaits
from tegotae.analysis.generalisation.disturbances import disturbances_named
from tegotae.analysis.generalisation.on_engine import ControllersUnderTest
from tegotae.analysis.generalisation.run import measure_retention
from tegotae.measures.gaits.summary import Coordination
from tegotae.parts.fields import replace
from tegotae.systems import controller_file
from tegotae.systems.controller_file import ControllerSet, SavedController
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import legged_system as system
from tegotae_robots.c import Export
from tegotae_robots.c.package import header
from tegotae_robots.c.source import source

KEPT = TESTS / "kept" / "pins.json"
LIBRARIES = ("jax", "jaxlib", "llvmlite", "numpy")
MUJOCO = ("gymnasium", "mujoco")
Results = dict[str, "np.ndarray | str"]


def study() -> Results:
    """All that the smoke study records: of a search, and of trainings of three generations."""
    return {
        f"{cell.name}.{name}": values
        for cell in plan("smoke").units
        for name, values in cell.measure().arrays.items()
    }


def generalisation() -> Results:
    """A leg and a quadruped under other conditions."""
    single = System(controller=recipe("V-reflex-w8").controller(), omega=8.0)
    hopper = ControllersUnderTest(
        ControllerSet("V", single, np.array([[2.0]]), ("0",)),
        looked_at=Timing(duration_s=24.0, tick_s=0.002),
    )
    legged = system("quadruped-c")
    walker = ControllersUnderTest(
        ControllerSet("C", legged.system, np.array([legged.weights]), ("0",)),
        starts=2,
        looked_at=dataclasses.replace(legged.timing, duration_s=60.0),
    )
    results: Results = {}
    for tested, conditions in (
        (hopper, ["mass=0.9/3.5", "delay=0.004"]),
        (walker, ["push-aside=0.001/9", "lost-leg=1"]),
    ):
        table = measure_retention(tested, disturbances_named(conditions)).table
        table["condition"] = table["condition"].to_numpy(str)
        results |= {f"{tested.name}.{name}": column.to_numpy() for name, column in table.items()}
    return results


def map_of_gaits() -> Results:
    """The gaits of two legs under a bar, over its inertia and the gain."""
    bar = replace(system("bar-light"), {"timing": Timing(duration_s=40.0)})
    drawn = map_gaits(bar, Axis("inertia_ratio", (0.6, 1.6)), Axis("sigma", (0.0, 1.0)), starts=3)
    result = {name: drawn.grid(name) for name in [*drawn.frame][3:]}
    of_legs = {
        name: np.stack([result[f"{column}_{leg}"] for leg in bar.names], axis=2)
        for name, column in _OF_LEGS.items()
    }
    alone = {name: result["moved_cycles" if name == "moved" else name] for name in _OF_BODY}
    return {**of_legs, **alone, "gait": result["gait"].astype(str)}


_OF_LEGS = {
    **{name: f"{name}_cycles" for name in ("lag", "lag_spread", "touchdown_lag")},
    **{name: name for name in ("step_frequency_hz", "duty_factor")},
}
_OF_BODY = [name for name in Coordination._fields if name not in _OF_LEGS]


def trained(*words: str) -> Results:
    """Return the result of `tegotae train`: weights and fitness of each seed, and the printed
    curves."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        with contextlib.redirect_stdout(io.StringIO()):
            assert cli.main(["--quiet", "train", *words, "--out", place]) == 0
        saved = [controller_file.load(path) for path in sorted(folder.glob("*-seed*.json"))]
        header, *rows = csv.reader((folder / "curves.csv").open())
    results: Results = {
        f"curves.{name}": np.array(column, float)
        for name, column in zip(header, zip(*rows, strict=True), strict=True)
    }
    results["weights"] = np.stack([single.weights for single in saved])
    results["best_fitness"] = np.array([single.training["best_fitness"] for single in saved])
    return results


def training() -> Results:
    """A hopper's, of two seeds."""
    return trained(*tiny.OPTIONS, "--generations", "3")


def training_of_legs() -> Results:
    """A quadruped's."""
    return trained(
        *("ART@quadruped-c", "--budget", "40", "--seeds", "1", "--population", "4"),
        *("--generations", "3", "--duration-s", "40"),
    )


def training_on_mujoco() -> Results:
    """A feedback's, on the MuJoCo hopper."""
    return trained(
        *("AR", "--env", "hopper", "--budget", "12", "--seeds", "2", "--population", "4"),
        *("--generations", "3", "--duration-s", "2.4"),
    )


def export_to_c() -> Results:
    """Source and header of a learned hopper, and of one with a gain, with given weights."""
    results: Results = {}
    for name in ("ART-rF-tphif-w8", "VG-gFv-sector-w4"):
        model = recipe(name)
        controller = model.controller(30)
        weights = np.random.default_rng(1).normal(size=controller.n_weights)
        saved = SavedController.from_weights(
            controller, weights, model.omega_t, Hopper(), name=name
        )
        created = Export(saved)
        results |= {f"{name}.c": source(created), f"{name}.h": header(created)}
    return results


PINS: dict[str, Callable[[], Results]] = {
    "study": study,
    "generalisation": generalisation,
    "map of gaits": map_of_gaits,
    "training": training,
    "training of legs": training_of_legs,
    "training on mujoco": training_on_mujoco,
    "export to C": export_to_c,
}


def hash_of(result: np.ndarray | str) -> str:
    """The hash of a text, or of an array's type, shape and bytes."""
    if isinstance(result, str):
        content = result.encode()
    elif result.dtype.kind in "OU":  # texts, of any width
        content = json.dumps(result.tolist()).encode()
    else:
        content = f"{result.dtype.str} {result.shape} ".encode() + result.tobytes()
    return hashlib.sha256(content).hexdigest()[:16]


def machine() -> dict[str, str]:
    """Return all that decides the bits, beside the code: the processor's kind, the libraries'
    versions."""
    fused = llvm.get_host_cpu_features().get("fma", False)
    libraries = [*LIBRARIES, *(MUJOCO if has_mujoco() else ())]
    return {
        "processor": f"{platform.machine()}{' with FMA' if fused else ''}",
        **{name: version(name) for name in libraries},
    }


def has_mujoco() -> bool:
    return all(importlib.util.find_spec(name) is not None for name in MUJOCO)


def hashes(name: str) -> dict[str, str]:
    """The hashes of a pin's results, by name."""
    return {key: hash_of(result) for key, result in PINS[name]().items()}


def unequal(kept: dict[str, str], current: dict[str, str]) -> list[str]:
    """Kept results that are others now, or are gone; new ones beside them are no difference."""
    return [key for key, value in kept.items() if current.get(key) != value]


def renew() -> None:
    """Keep what it does now."""
    document = {"machine": machine(), "pins": {name: hashes(name) for name in PINS}}
    KEPT.write_text(json.dumps(document, indent=1) + "\n")


def compare() -> bool:
    """Print which pins differ from the kept ones; whether none does."""
    stored, current = json.loads(KEPT.read_text()), machine()
    changed = {name for name, value in stored["machine"].items() if current.get(name) != value}
    equal = True
    for name, previous in stored["pins"].items():
        needed = changed if name == "training on mujoco" else changed - set(MUJOCO)
        if needed:
            print(f"{name}: not compared, for {', '.join(sorted(needed))} is another")
            continue
        begin = time.process_time()
        different = unequal(previous, hashes(name))
        took = f"{time.process_time() - begin:.1f} s"
        message = f"other bits in {', '.join(different)}" if different else "equal to the bit"
        print(f"{name}: {len(previous)} results in {took}, {message}", flush=True)
        equal = equal and not different
    return equal


if __name__ == "__main__":
    if "--renew" in sys.argv:
        sys.exit(renew())
    sys.exit(not compare())
