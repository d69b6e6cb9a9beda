"""A simulated robot's wheels, arm and hand."""
