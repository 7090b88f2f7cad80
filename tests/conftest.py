"""All tests run under JAX's strict promotion rules: no silent change of dtype or rank."""

from __future__ import annotations

import jax
from hypothesis import settings

import tegotae  # noqa: F401 - first, for it asks JAX for one device per core

jax.config.update("jax_numpy_dtype_promotion", "strict")
jax.config.update("jax_numpy_rank_promotion", "raise")

# The same examples in every run, and no deadline: the first call of a function compiles it.
settings.register_profile("tegotae", deadline=None, derandomize=True, max_examples=40)
settings.load_profile("tegotae")
