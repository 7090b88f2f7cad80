"""Controllers as C: the controller's own tick, traced and written out for a microcontroller."""

from tegotae.export.plan import Export


__all__ = ["Export"]
