"""Explanation of a past run: why its actions were chosen, and why they failed."""
