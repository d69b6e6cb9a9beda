"""Report about a robot from its files, without moving it."""
