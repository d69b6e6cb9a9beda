"""Readings of the robot's sensors in physics."""
