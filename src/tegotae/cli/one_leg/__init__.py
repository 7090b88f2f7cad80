"""What commands do for a body with one leg, one file a command."""
