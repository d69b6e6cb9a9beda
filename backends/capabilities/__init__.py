"""Capabilities of a backend."""
