"""Numbers of a trajectory: metrics, objectives, evaluation, gaits, recordings, the optimum."""
