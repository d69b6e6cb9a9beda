"""Primitives that move the base, or plan how."""
