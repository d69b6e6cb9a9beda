"""Report on a robot from its files, without moving it."""
