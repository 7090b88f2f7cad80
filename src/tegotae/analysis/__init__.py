"""Analyses of one controller, or of many: limit cycles, basins, gaits, robustness."""
