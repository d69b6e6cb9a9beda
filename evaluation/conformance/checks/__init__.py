"""Checks of a backend's contract."""
