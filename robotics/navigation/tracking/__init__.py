"""Tracking of what moves among the beams of a lidar."""
