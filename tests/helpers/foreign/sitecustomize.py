"""A Python without POSIX, on a PYTHONPATH: Windows' lock in place of fcntl, no affinity, no users.

What Windows lacks is taken away before anything is imported, in this process and in those that it
starts; `msvcrt.locking` is played by the lock of a file.
"""

import errno
import fcntl as _fcntl
import multiprocessing.util  # noqa: F401  (as subprocess, it asks for msvcrt when it is imported)
import os
import signal
import subprocess  # noqa: F401
import sys
import tempfile  # noqa: F401
import types


def _locking(file: int, mode: int, count: int) -> None:
    """Lock a file, or fail as Windows does where another process has it."""
    try:
        _fcntl.flock(file, _fcntl.LOCK_EX | _fcntl.LOCK_NB)
    except BlockingIOError:
        raise PermissionError(errno.EACCES, "Permission denied") from None


sys.modules["msvcrt"] = types.SimpleNamespace(locking=_locking, LK_NBLCK=2)  # type: ignore
for name in ("fcntl", "resource"):
    sys.modules[name] = None  # type: ignore[assignment]
for name in ("getuid", "getgid", "sched_getaffinity", "O_NOFOLLOW", "O_NONBLOCK"):
    delattr(os, name)
for name in ("SIGHUP", "SIGKILL", "SIGALRM", "pthread_sigmask"):
    delattr(signal, name)
