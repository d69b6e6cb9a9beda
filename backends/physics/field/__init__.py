"""Sensors and their gripper in physics."""
