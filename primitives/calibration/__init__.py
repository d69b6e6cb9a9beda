"""Primitives that measure values of a robot's file."""
