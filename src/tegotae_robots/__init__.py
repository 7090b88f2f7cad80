"""From a robot's model, or its log, to a law on the robot; and a benchmark of what drives one."""
