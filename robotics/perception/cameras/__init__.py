"""Cameras: their lens, their place on the hand, and how both are calibrated."""
