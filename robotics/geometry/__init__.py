"""Poses in the plane and in space."""
