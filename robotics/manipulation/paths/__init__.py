"""Paths of a tool, and why one can't be tracked."""
