"""Objects with tags in simulated worlds."""
