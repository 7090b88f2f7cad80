"""Figures, each made by a function that returns it."""
