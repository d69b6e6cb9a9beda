"""The URDF of a robot as physics engines get it."""
