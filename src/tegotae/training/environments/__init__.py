"""Training on another simulator: limbs that are wired into a Gymnasium environment."""
