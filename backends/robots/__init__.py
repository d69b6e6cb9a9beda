"""Robots: a URDF with a YAML file beside it."""
