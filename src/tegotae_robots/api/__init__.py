"""Questions about robots, their options and their answers, for Python and the shell alike."""
