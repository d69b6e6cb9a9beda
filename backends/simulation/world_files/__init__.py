"""World files: loading, findings, and the map of a world."""
