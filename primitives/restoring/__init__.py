"""Restoring everything to its earlier state, measured."""
