"""Training on somebody else's simulator: limbs that are wired into a Gymnasium environment."""
