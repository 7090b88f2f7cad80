"""What commands do for a body of your own: a first wiring, and a baseline."""
