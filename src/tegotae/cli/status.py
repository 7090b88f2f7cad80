"""How a command ends: one line on stderr if it fails, and an exit status."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable

from jax.errors import JaxRuntimeError

from tegotae.errors import TegotaeError

UNUSABLE_INPUT = 2
INTERRUPTED = 130


def exit_status(command: Callable[[], None]) -> int:
    """Run a command; 0, or 2 for what it cannot use or do, or 130 after Ctrl-C.

    What is wrong is printed in one line. A program error is not: it ends in its traceback.
    """
    try:
        command()
        sys.stdout.flush()
    except TegotaeError as error:
        return _fail(str(error))
    except MemoryError:
        return _fail("out of memory; use fewer lanes or a shorter duration")
    except JaxRuntimeError as error:
        if "RESOURCE_EXHAUSTED" not in str(error):
            raise
        return _fail("out of memory; use fewer lanes or a shorter duration")
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        _discard_output()
    except OSError as error:
        _discard_output()
        return _fail(str(error))
    except KeyboardInterrupt as stop:
        return _fail(str(stop) or "interrupted", INTERRUPTED)
    return 0


def leave(status: int) -> None:
    """End the process. After Ctrl-C at once: XLA aborts if Python takes it down while it works."""
    if status == INTERRUPTED:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    sys.exit(status)


def _fail(line: str, status: int = UNUSABLE_INPUT) -> int:
    print(f"tegotae: {line}", file=sys.stderr)
    return status


def _discard_output() -> None:
    """Let what is still buffered go nowhere, or Python would fail on it once more at its end."""
    with contextlib.suppress(OSError, ValueError):  # no real file, as in a test
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
