"""`handcart map`: maps from recorded logs, and tools for maps."""
