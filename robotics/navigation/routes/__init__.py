"""Ways over a map and past round obstacles."""
