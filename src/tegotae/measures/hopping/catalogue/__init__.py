"""The package's metrics, one a module: its `METRIC`, and how it is computed."""
