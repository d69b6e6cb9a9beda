"""Doors and drawers in physics."""
