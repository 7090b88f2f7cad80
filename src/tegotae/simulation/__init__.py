"""How a closed loop moves, what it meets, and what is recorded."""
