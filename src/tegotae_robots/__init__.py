"""Bring a law to a robot: from the robot's model, or from its log; and benchmark controllers of
robots."""
