"""Simulated worlds: what stands around the robot, and what its sensors see of it."""
