"""What ground truth says of blocks."""
