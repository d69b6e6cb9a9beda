"""Kinds of sensors with their parts, by the name in a robot's file."""
