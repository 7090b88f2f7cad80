"""Memory of this process, and how it is given back."""

import ctypes
import gc
import resource
import sys
from pathlib import Path

import jax

from tegotae.simulation.native import forget_programs


def resident_mib() -> float:
    """Memory that the process has now [MiB]; 0 where the system does not say."""
    try:
        pages = Path("/proc/self/statm").read_text().split()[1]
    except OSError:
        return 0.0
    return int(pages) * resource.getpagesize() / 2**20


def peak_mib() -> float:
    """The most memory that the process ever had [MiB]."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 2**20 if sys.platform == "darwin" else peak / 2**10


_LARGE_MIB = 1000.0
_STEP_MIB = 100.0
_largest = [_LARGE_MIB]
"""Memory from which on it is given back; more where that much remained the last time."""


def give_back_if_large() -> None:
    """Drop compiled programs, which the disk has, and return freed memory to the system."""
    if resident_mib() < _largest[0]:
        return
    forget_programs()
    jax.clear_caches()
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # of glibc alone
    if trim is not None:
        trim(0)
    _largest[0] = max(_LARGE_MIB, resident_mib() + _STEP_MIB)
