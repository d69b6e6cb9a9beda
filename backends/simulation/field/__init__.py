"""What a field of sensors has in it, in simulated worlds."""
