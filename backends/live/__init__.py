"""Common parts of real robots: the clock of the control loop, and free-running sensors."""
