"""Poses of boxes with printed tags."""
