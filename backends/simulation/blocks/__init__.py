"""Blocks in simulated worlds."""
