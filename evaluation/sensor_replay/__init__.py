"""Recorded readings of a run, and the replay that must draw the same commands from them."""
