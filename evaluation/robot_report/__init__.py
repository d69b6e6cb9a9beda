"""What can be known about a robot from its files, without moving it."""
