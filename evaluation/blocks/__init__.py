"""Ground truth of blocks."""
