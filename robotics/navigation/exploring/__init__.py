"""Exploration: a map that grows while a robot drives, and where it ends."""
