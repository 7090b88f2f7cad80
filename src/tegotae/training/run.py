"""A training run on disk: controllers, curves, and a checkpoint from which it goes on."""

from __future__ import annotations

import io
import json
import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jax
import numpy as np

from tegotae._support.arrays import read_arrays
from tegotae._support.devices import set_up
from tegotae._support.documents import fitted, parse
from tegotae._support.errors import TegotaeError, require_count
from tegotae._support.files import write_atomically
from tegotae._support.limits import require_memory
from tegotae._support.progress import reporting
from tegotae._support.tables import write_csv
from tegotae._support.workplace import TRAINING, alone
from tegotae.measures.hopping.statistics import mean_defined
from tegotae.systems.descriptions import check_kept
from tegotae.systems.experiment import differing
from tegotae.training.algorithms import PGPE, Algorithm
from tegotae.training.algorithms.document import algorithm_document
from tegotae.training.evaluator import evaluator_of
from tegotae.training.evolve import Curves, Progress, evolve, start
from tegotae.training.folder import claim, save_controller, versions_of
from tegotae.training.search import best_gain
from tegotae.training.stopping import SEARCH, Stopping
from tegotae.training.trainable import Trainable

_SECONDS_BETWEEN_CHECKPOINTS = 5.0
_MOST_BYTES = 2**30
"""What a checkpoint may unpack to [bytes]."""
_REMEDY = "remove it to train anew, or choose another folder with --out"


@dataclass(frozen=True, kw_only=True)
class Run:
    """A training by an evolution strategy: what, from which seeds, how, and until when.

    Args:
        experiment: what is trained, on what, by what measure: an `Experiment` on the engine, or a
            `EnvExperiment` on an environment.
        seeds: one training from random weights each.
        stopping: when a run ends; `Stopping.after(n)` for exactly n generations.
        algorithm: how is learned.
        workers: worker processes, where episodes are not the engine's; one a core by default. With
            another number of them results differ by rounding, which training magnifies.

    Raises:
        TegotaeError: for seeds that are no distinct numbers from 0 to 2^31 - 1.
    """

    experiment: Trainable
    seeds: tuple[int, ...] = (0, 1, 2)
    stopping: Stopping = field(default_factory=Stopping)
    algorithm: Algorithm = field(default_factory=PGPE)
    workers: int | None = None

    def __post_init__(self) -> None:
        require_count("seeds", len(self.seeds))
        for seed in self.seeds:
            require_count("seed", seed, least=0)
            if seed >= 2**31:
                raise TegotaeError(f"seed is {seed}; it must be below 2^31 ({2**31})")
        if len(set(self.seeds)) < len(self.seeds):
            raise TegotaeError(f"seeds are {self.seeds}; each may be given only once")

    @property
    def program(self) -> tuple[Any, ...]:
        """What is compiled: trainings of which this is equal share it."""
        with evaluator_of(self.experiment) as evaluator:
            return (self.algorithm.program, *evaluator.program)

    @property
    def configuration(self) -> dict[str, Any]:
        """What decides the result, but for the cap on generations, as JSON values."""
        return {
            "experiment": self.experiment.document,
            "seeds": list(self.seeds),
            "algorithm": algorithm_document(self.algorithm),
            "stopping": self.stopping.rule,
        }

    def start(self) -> Progress:
        """Every seed's own random weights."""
        return start(self.algorithm, self.experiment.controller, self.seeds)

    def evolve(self, progress: Progress, fitness: Any = None) -> Iterator[tuple[Progress, Curves]]:
        """Train on until every seed has ended; see `tegotae.training.evolve.evolve`."""
        with evaluator_of(self.experiment, self.workers) as evaluator:
            yield from evolve(
                self.algorithm, evaluator, progress, self.seeds, self.stopping, fitness=fitness
            )

    def search(self) -> tuple[float, float]:
        """The σ of a pure V model, and its fitness."""
        return best_gain(self.experiment, self.workers)


def software() -> dict[str, str]:
    """Versions of the programs that decide the numbers."""
    return versions_of("evosax")


def train(
    run: Run,
    out: Path,
    *,
    anew: bool = False,
    on_generation: Callable[[int, Curves], None] | None = None,
) -> list[Path]:
    """Train, or train on, in the folder `out`; return the controller files, one per seed.

    Written are `MODEL-seedN.json` (the controllers), `curves.csv`, `run.json` (configuration and
    versions) and `checkpoint.npz`. Interrupted (Ctrl-C), it keeps what has been learned and
    raises `KeyboardInterrupt` again; called again on the same folder, it goes on from there, and
    ends in the same numbers. A pure V model has no network: its σ is found by search, which is one
    run whatever the seeds.

    Args:
        run: what, from which seeds, how, and until when.
        out: the folder.
        anew: whether a training that is there before is set aside, in a folder beside it.
        on_generation: called with the number and the curves of each new generation.

    Raises:
        TegotaeError: if the folder cannot be written, is in use or holds another training.
    """
    set_up()
    run.experiment.check()
    check_kept(run.algorithm)
    _require_room(run)
    with alone(out, TRAINING, anew=anew):
        claim(out, run.configuration, software())
        return _train(run, out, on_generation)


def _require_room(run: Run) -> None:
    """Raise `TegotaeError` if a generation's weights and noise would not fit into the memory."""
    episodes = run.algorithm.population * run.experiment.episodes
    n_weights = run.experiment.controller.n_weights
    require_memory(
        8.0 * 4 * len(run.seeds) * episodes * n_weights,
        f"{episodes} episodes a generation, of {len(run.seeds)} seeds and {n_weights} weights,",
    )


def _train(
    run: Run,
    out: Path,
    on_generation: Callable[[int, Curves], None] | None,
) -> list[Path]:
    """The same, alone in the folder."""
    if run.experiment.is_searched:
        return _search(run, out)
    reached = begun, curves = _resume(run, out)
    saved_at, paths = -math.inf, []
    with reporting(run.experiment.name, run.stopping.generations) as reporter:
        try:
            for progress, new in run.evolve(begun, [c.centre_fitness for c in curves]):
                # In one assignment: an interrupt must not come between the two.
                reached = progress, [*reached[1], new]
                done = len(reached[1])
                if time.monotonic() - saved_at > _SECONDS_BETWEEN_CHECKPOINTS:
                    _checkpoint(run, out, *reached)
                    saved_at = time.monotonic()
                ended = sum(map(bool, ends(run, reached[1])))
                reporter.update(
                    done,
                    f"fitness {float(np.mean(progress.best_fitness)):+.3f}  "
                    f"{_efficiency(run, new)}{ended} of {len(run.seeds)} runs ended",
                )
                if on_generation is not None:
                    on_generation(done, new)
        finally:
            if reached[1]:
                _checkpoint(run, out, *reached)
                paths = _write_results(run, *reached, out)
    return paths


def _efficiency(run: Run, curves: Curves) -> str:
    """CoT⁻¹ in words; nothing where no objective measures it."""
    unit = run.experiment.cot_unit
    mean = float(mean_defined(curves.centre_cot_inverse))
    return "" if math.isnan(mean) else " ".join(["CoT⁻¹", f"{mean:.3f}", *unit.split()]) + "  "


def ends(run: Run, curves: Sequence[Curves]) -> list[str]:
    """Why each seed has ended: on its plateau, at the cap, or not yet (empty)."""
    return run.stopping.reasons(np.array([c.centre_fitness for c in curves]))


def _resume(run: Run, out: Path) -> tuple[Progress, list[Curves]]:
    progress = run.start()
    path = out / "checkpoint.npz"
    if not path.exists():
        return progress, []
    leaves, structure = jax.tree.flatten(progress)
    with _useless(path):
        arrays = read_arrays(path, _MOST_BYTES)
        found = fitted(parse(str(arrays.get("configuration", "{}"))), dict)
    if names := differing(found, json.loads(json.dumps(run.configuration))):
        earlier = "experiment" not in found
        what = "an earlier version" if earlier else f"a training that differs in {', '.join(names)}"
        raise TegotaeError(f"{path} is of {what}; {_REMEDY}")
    with _useless(path):
        restored = [arrays[f"leaf{i}"] for i in range(len(leaves))]
        columns = [arrays[f"curve_{name}"] for name in Curves._fields]
        for ours, theirs in zip(leaves, restored, strict=True):
            if (ours.shape, ours.dtype) != (theirs.shape, theirs.dtype):
                raise ValueError("shapes or types differ")
        curves = [Curves(*generation) for generation in zip(*columns, strict=True)]
        reached = jax.tree.unflatten(structure, [jax.numpy.asarray(x) for x in restored])
        if np.max(reached.generation) != len(curves):
            raise ValueError("curves and progress differ in length")
    return reached, curves


@contextmanager
def _useless(path: Path) -> Iterator[None]:
    """Say in one line of a checkpoint that cannot be used what is wrong."""
    try:
        yield
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except (TypeError, ValueError, KeyError):
        raise TegotaeError(f"{path} is damaged; {_REMEDY}") from None


def _checkpoint(run: Run, out: Path, progress: Progress, curves: list[Curves]) -> None:
    arrays = {f"leaf{i}": np.asarray(x) for i, x in enumerate(jax.tree.leaves(progress))}
    for name in Curves._fields:
        arrays[f"curve_{name}"] = np.stack([getattr(c, name) for c in curves])
    arrays["configuration"] = np.array(json.dumps(run.configuration))
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **arrays)
    write_atomically(out / "checkpoint.npz", stream.getvalue())


def _write_results(run: Run, progress: Progress, curves: list[Curves], out: Path) -> list[Path]:
    trained = [
        (generation, i)
        for generation in range(len(curves))
        for i in range(len(run.seeds))
        if generation < progress.generation[i]
    ]
    told = {
        name: [float(getattr(curves[generation], name)[i]) for generation, i in trained]
        for name in Curves._fields
    }
    which = {"generation": [g for g, _ in trained], "seed": [run.seeds[i] for _, i in trained]}
    write_csv(out / "curves.csv", which | told, digits=6)
    paths = []
    for i, (seed, reason) in enumerate(zip(run.seeds, ends(run, curves), strict=True)):
        outcome = {
            "seed": seed,
            "generations": int(progress.generation[i]),
            "ended": reason,
            "best_fitness": float(progress.best_fitness[i]),
            "best_generation": int(progress.best_generation[i]),
        }
        paths.append(_save(run, np.asarray(progress.best_weights[i]), outcome, out))
    return paths


def _save(run: Run, weights: np.ndarray, outcome: dict[str, Any], out: Path) -> Path:
    return save_controller(
        out,
        experiment=run.experiment,
        controller=run.experiment.controller,
        weights=weights,
        configuration=run.configuration,
        outcome=outcome,
        versions=software(),
    )


def _search(run: Run, out: Path) -> list[Path]:
    gain, fitness = run.search()
    # The search has no randomness: it is one run, whatever the seeds.
    outcome = {
        "seed": run.seeds[0],
        "best_fitness": fitness,
        "generations": 0,
        "ended": SEARCH,
        "best_generation": 0,
    }
    return [_save(run, np.array([gain]), outcome, out)]
