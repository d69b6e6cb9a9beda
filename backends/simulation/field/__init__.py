"""Objects of a field of sensors in simulated worlds."""
