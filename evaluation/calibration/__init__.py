"""Ground truth of calibrations."""
