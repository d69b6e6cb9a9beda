"""Capabilities that a backend may have."""
