"""Commands about many runs of one task."""
