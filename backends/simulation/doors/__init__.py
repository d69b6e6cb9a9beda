"""Doors and drawers in simulated worlds."""
