"""A field: its targets, and how sensors are laid there."""
