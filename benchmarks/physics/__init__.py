"""Benchmarks of the physics engines."""
