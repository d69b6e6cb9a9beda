"""Checks of the times, fixes and axes of a recorded log."""
