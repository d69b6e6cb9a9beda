"""A robot's URDF: its parts, its shape, its meshes."""
