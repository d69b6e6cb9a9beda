"""Books and shelves in simulated worlds."""
