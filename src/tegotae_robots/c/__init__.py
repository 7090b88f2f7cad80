"""Controllers as C: the controller's own tick, traced and written out for a microcontroller."""

from tegotae_robots.c.package import LAYOUTS, package_texts
from tegotae_robots.c.plan import Export

__all__ = ["LAYOUTS", "Export", "package_texts"]
