"""The robot that returns books."""
