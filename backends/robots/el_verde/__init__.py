"""El-Verde, which lays sensors outdoors."""
