"""A seam: how it is divided among places of the base, and tracked."""
