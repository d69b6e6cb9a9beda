"""Ground truth, metrics, campaigns."""
