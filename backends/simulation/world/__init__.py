"""The robot's surroundings, built from a world's file."""
