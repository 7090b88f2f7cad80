"""Gaits: how the legs of a body go together, and when that changes."""
