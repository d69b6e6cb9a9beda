"""What simulated backends share: a world, a body in it, and its sensors."""
