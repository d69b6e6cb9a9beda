"""Arms: forward and inverse kinematics from a URDF."""
