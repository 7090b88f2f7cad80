"""CMA-ES with as many weights as the paper's controllers have."""

import ctypes
import subprocess
import sys

import pytest
from scipy.linalg import cython_lapack

from tegotae.training.algorithms import CMAES


@pytest.mark.thorough
def test_it_ends_with_ninety_six_weights_and_several_seeds(tmp_path):
    # In a process of its own: what went wrong once is a wait for ever, of two devices for a pool.
    words = ("ART", "--algorithm", "cma-es", "--seeds", "4", "--population", "8")
    options = (
        "--generations",
        "3",
        "--duration-s",
        "3",
        "--settle-s",
        "1",
        "--out",
        str(tmp_path / "o"),
    )
    ended = subprocess.run(
        [sys.executable, "-m", "tegotae", "train", *words, *options],
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert ended.returncode == 0, ended.stderr
    assert len(list((tmp_path / "o").glob("*seed?.json"))) == 4


def test_scipys_blas_has_one_thread_when_devices_wait_for_it():
    CMAES(population=8).strategy(3)
    library = ctypes.CDLL(cython_lapack.__file__)
    if not hasattr(library, "scipy_openblas_get_num_threads"):
        pytest.skip("SciPy is built on another BLAS")
    assert library.scipy_openblas_get_num_threads() == 1
