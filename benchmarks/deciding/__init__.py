"""Benchmarks of decisions under uncertainty."""
