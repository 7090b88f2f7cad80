"""The whole study: every model, many runs, one record each, in a folder that survives all."""
