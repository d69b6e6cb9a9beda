"""What ground truth says of calibrations."""
