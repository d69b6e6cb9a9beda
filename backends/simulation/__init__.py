"""Common parts of simulated backends: a world, a body in it, and its sensors."""
