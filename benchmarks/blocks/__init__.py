"""Stacking, measured."""
