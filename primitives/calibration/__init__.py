"""Primitives that measure what a robot's file says."""
