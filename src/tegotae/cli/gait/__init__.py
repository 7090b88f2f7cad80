"""`tegotae gait`: how the legs of a body go together, one file a command."""
