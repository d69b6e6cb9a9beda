"""Keeping a tool on a path."""
