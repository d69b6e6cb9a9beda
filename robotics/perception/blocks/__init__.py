"""Blocks, by the edges of their faces."""
