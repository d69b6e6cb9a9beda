"""A first robot file for a URDF."""
