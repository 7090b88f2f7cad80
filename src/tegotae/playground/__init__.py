"""A page to play with: the closed loop as WebAssembly, and what people do to it."""

from tegotae.playground.page import Choice, Page
from tegotae.playground.standard import standard

__all__ = ["Choice", "Page", "standard"]
