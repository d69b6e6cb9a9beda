"""Exploration of unmapped ground: looks around, drives to frontiers, the way home, and the map in the end."""
