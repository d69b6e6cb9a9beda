"""A run with its metrics, and many of them."""
