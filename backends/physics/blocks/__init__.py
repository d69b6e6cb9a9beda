"""Blocks in physics."""
