"""Parts of a closed loop: bodies, terrains, oscillators, terms, couplings, controllers."""

from tegotae._support.errors import require_count, require_finite

__all__ = ["require_count", "require_finite"]
