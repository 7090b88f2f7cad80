"""How the legs of a body go together, and the names of gaits."""
