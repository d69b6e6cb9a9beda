"""Test rig of a backend."""
