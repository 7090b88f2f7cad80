"""Functions for robots, with their options and results, for Python and the command line."""
