"""A cart with an arm and a tray."""
