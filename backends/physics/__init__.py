"""Common parts of backends with physics, independent of the engine."""
