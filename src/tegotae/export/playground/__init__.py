"""A page to play with: the closed loop as WebAssembly, and what people do to it."""

from tegotae.export.playground.page import ControllerChoice, Page
from tegotae.export.playground.standard import standard

__all__ = ["ControllerChoice", "Page", "standard"]
