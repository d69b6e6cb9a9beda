"""A test bench: simulated drives in front of a simulated robot, and faults that can be injected."""
