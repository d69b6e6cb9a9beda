"""Ground truth of sensors laid in a field."""
