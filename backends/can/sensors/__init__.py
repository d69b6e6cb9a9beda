"""Drivers of the sensors of a real robot that are not on its CAN bus."""
