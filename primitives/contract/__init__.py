"""The contract of a primitive, and the attempt that enforces it."""
