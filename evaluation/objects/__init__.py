"""Ground truth of fetching and carrying objects."""
