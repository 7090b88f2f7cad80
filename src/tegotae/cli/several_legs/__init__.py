"""What commands do for a body with several legs, one file a command."""
