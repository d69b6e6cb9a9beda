"""Draft of a robot's file for a URDF."""
