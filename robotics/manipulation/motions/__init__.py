"""Motions of an arm that touch nothing, in time."""
