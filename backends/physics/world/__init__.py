"""Surroundings of the robot in physics."""
