"""What commands do for controllers of limbs that another simulator moves, one file a command."""
