"""Memory of this process, and how it is given back."""

from __future__ import annotations

import ctypes
import gc
import resource
import sys
from pathlib import Path

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


def give_back() -> None:
    """Drop compiled programs, which the disk has, and return freed memory to the system."""
    forget_programs()
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # of glibc alone
    if trim is not None:
        trim(0)
