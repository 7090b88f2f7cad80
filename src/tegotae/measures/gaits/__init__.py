"""Coordination of the legs of a body, and the names of gaits."""
