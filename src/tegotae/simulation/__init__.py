"""Motion, conditions and recording of a closed loop."""
