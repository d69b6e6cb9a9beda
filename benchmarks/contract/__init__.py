"""Benchmarks of what every primitive and every request must keep to."""
