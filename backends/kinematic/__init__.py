"""The kinematic backend."""
