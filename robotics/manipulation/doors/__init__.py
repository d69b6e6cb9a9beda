"""Doors and drawers: how they move, estimated from the path of their handles."""
