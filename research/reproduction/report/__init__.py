"""The study's report: one HTML page that needs nothing else."""
