"""`tegotae figure`: pictures that explain a controller, one file a picture."""
