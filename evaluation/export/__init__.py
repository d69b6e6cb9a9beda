"""Runs and campaigns in the formats of other programs."""
