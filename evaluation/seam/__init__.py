"""Ground truth of tracked seams, and places of the base for a seam."""
