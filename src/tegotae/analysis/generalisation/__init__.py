"""What trained controllers do, unchanged, in conditions that they were not trained in."""
