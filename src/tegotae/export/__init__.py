"""Controllers as C: the controller's own tick, traced and written out for a microcontroller."""

from tegotae.export.plan import Export
from tegotae.export.write import write

__all__ = ["Export", "write"]
