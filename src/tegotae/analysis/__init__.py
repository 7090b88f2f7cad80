"""Questions asked of a controller, or of many: limit cycles, basins, gaits, generalisation."""
