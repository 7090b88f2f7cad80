"""Solutions of adaptive solvers, saved as data: solved again when code or question changes.

`make solutions` solves all anew and keeps it; so does `make test-thorough`, which compares.
"""

import functools
import hashlib
import inspect
import os
from pathlib import Path

import numpy as np

FILE = Path(__file__).parents[1] / "kept" / "solutions.npz"
ANEW = "TEGOTAE_SOLVE"
"""Set to `keep` or `compare`: solve all anew."""
_solved: dict[str, dict[str, np.ndarray]] = {}


@functools.cache
def _kept() -> dict[str, dict[str, np.ndarray]]:
    result: dict[str, dict[str, np.ndarray]] = {}
    if FILE.exists():
        with np.load(FILE) as archive:
            for name, value in archive.items():
                key, _, part = name.partition("/")
                result.setdefault(key, {})[part] = value
    return result


def kept(solve):
    """A solver whose answers, dataclasses of arrays, are kept by its module and its arguments."""
    code = inspect.getsource(inspect.getmodule(solve))

    @functools.wraps(solve)
    def answer(*args, **names):
        requested = f"{code}\0{args!r}\0{sorted(names.items())!r}"
        key = hashlib.sha256(requested.encode()).hexdigest()[:16]
        kind = inspect.get_annotations(solve, eval_str=True)["return"]
        if key in _kept() and ANEW not in os.environ:
            return kind(**{name: value[()] for name, value in _kept()[key].items()})
        flown = solve(*args, **names)
        _solved[key] = {name: np.asarray(value) for name, value in vars(flown).items()}
        if os.environ.get(ANEW) == "compare" and key in _kept():
            for name, value in _kept()[key].items():
                np.testing.assert_allclose(_solved[key][name], value, rtol=1e-6, atol=1e-6)
        return flown

    return answer


def keep() -> None:
    """Keep what was solved in this process, and nothing else."""
    np.savez_compressed(
        FILE,
        **{f"{key}/{part}": x for key, parts in _solved.items() for part, x in parts.items()},
    )
