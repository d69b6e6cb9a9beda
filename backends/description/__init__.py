"""A robot's file, and what is wrong with it."""
