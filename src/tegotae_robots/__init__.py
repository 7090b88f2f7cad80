"""From a robot's model, or its log, to a law on the robot: wirings, templates, fitted bodies, C, the
live loop; and a benchmark."""
