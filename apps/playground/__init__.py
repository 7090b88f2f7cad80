"""A page to play with: the closed loop as WebAssembly, and what people do to it."""

from apps.playground.page import ControllerChoice, Page
from apps.playground.standard import standard

__all__ = ["ControllerChoice", "Page", "standard"]
