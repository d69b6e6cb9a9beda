"""What ground truth says of sensors laid in a field."""
