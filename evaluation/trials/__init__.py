"""A run with its metrics."""
