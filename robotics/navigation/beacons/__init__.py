"""Positions by ranges to radio beacons whose places are known."""
