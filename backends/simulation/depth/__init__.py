"""Simulated depth cameras: how depth is computed from a scene, and how it errs."""
