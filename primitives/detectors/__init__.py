"""Detectors of objects from other packages."""
