"""Programs of XLA: compiled in little time, and kept whole and checked in this user's folder."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Any

import jax

from tegotae._support import compiled


class KeptPrograms:
    """Compiled code in the place of a cache of JAX's.

    Args:
        path: the folder.
    """

    def __init__(self, path: str) -> None:
        self._path = Path(path)

    def get(self, key: str) -> bytes | None:
        """Return the program of a key, or None if there is none that is complete."""
        return compiled.stored_code(compiled.key_of_xla_program(key))

    def put(self, key: str, value: bytes) -> None:
        """Keep a program."""
        compiled.store_code(compiled.key_of_xla_program(key), value)


def use_kept_programs() -> None:
    """Let JAX keep its programs if its folder is ours; another folder is left unchanged.

    JAX has no public way to that. Where this one is lacking, it keeps none.
    """
    try:
        from jax._src import compilation_cache

        plain = compilation_cache.get_file_cache
    except (ImportError, AttributeError):
        if os.environ.get(compiled.JAX_VARIABLE) == compiled.xla_folder(compiled.folder()):
            jax.config.update("jax_compilation_cache_dir", None)
        return

    def cache_of(path: str) -> Any:
        return (
            (KeptPrograms(path), path)
            if path == compiled.xla_folder(compiled.folder())
            else plain(path)
        )

    compilation_cache.get_file_cache = cache_of  # pyright: ignore


@cache
def one_module() -> dict[str, str | bool]:
    """Return compiler options that make one module of a program in place of one per loop.

    On a processor XLA then compiles in a third of the time, to the same bits. A release that has
    no such options compiles without them.
    """
    options: dict[str, str | bool] = {
        "xla_cpu_use_fusion_emitters": False,
        "xla_cpu_parallel_codegen_split_count": "1",
    }
    try:
        jax.jit(lambda: 0, compiler_options=options).lower().compile()
    except jax.errors.JaxRuntimeError:
        return {}
    return options
