"""Driving along a route, to a pose, and no farther than is free."""
