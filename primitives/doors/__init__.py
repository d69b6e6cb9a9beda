"""Doors and drawers: what is known of them, and how a hand opens and closes them."""
