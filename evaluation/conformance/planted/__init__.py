"""Liars that the kit has to find."""
