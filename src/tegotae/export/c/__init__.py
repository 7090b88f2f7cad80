"""Controllers as C: the controller's own tick, traced and written out for a microcontroller."""

from tegotae.export.c.plan import Export
from tegotae.export.c.write import write

__all__ = ["Export", "write"]
