"""Named systems, experiments, controller files, and users' own objects."""
