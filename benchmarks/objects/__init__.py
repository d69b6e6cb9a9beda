"""Benchmarks of fetching and carrying objects."""
